//! The light of a flat iris beside its layers and random walks, and how far light spreads between its fibres.

use super::super::iris_relief::iris_landing;
use super::super::iris_relief::{IRIS_MARCH_FAST, IRIS_MARCH_FULL, stroma_density};
use super::*;
use crate::frame::mips::chain;
use crate::optics::cornea::cornea_trace;
use crate::tissue::iris_layers::forward_layers;
use crate::tissue::iris_reflectance::{AQUEOUS_COSINE, IrisPigment, IrisReflectanceTable, matched};
use crate::tissue::layers::layer_reflect_once;
use crate::tissue::phase::phase_mix;
use crate::tissue::random_walk::{Illumination, random_walk_within};
use crate::tissue::wavelengths::Wavelengths;

/// A flat iris of one thickness and density.
fn flat(thickness: f32, melanin: f32) -> IrisMaps {
    let map = |texel: [f32; 4]| MapView::new(&chain((4, 4), vec![texel; 16]), true);
    IrisMaps {
        relief: map([thickness, melanin, 0.0, 0.0]),
        reflectance: map([0.0; 4]),
        light: map([0.0; 4]),
    }
}

fn frame() -> IrisFrame {
    IrisFrame {
        root: 6.05,
        pupil: 1.75,
        limbus: 5.85,
        relief: 1.0,
        center: DVec2::ZERO,
        thicken: 1.0,
        furrows: 1.0,
        cone: 0.0,
        bow: 0.0,
    }
}

/// Radiance by one scattering of light of this cosine seen at another, a turn (rad) apart.
fn once(
    maps: &IrisMaps,
    tissue: &IrisTissue,
    [into, out, turn]: [f64; 3],
    march: &IrisMarch,
) -> DVec3 {
    let slanted = |cosine: f64, turn: f64| {
        let sine = (1.0 - cosine * cosine).sqrt();
        DVec3::new(sine * turn.cos(), sine * turn.sin(), -cosine)
    };
    let direction = -slanted(out, 0.0);
    let point = DVec2::new(3.5, 0.0);
    let surface = iris_surface(
        maps,
        &frame(),
        point,
        &iris_place(point, &frame()),
        direction,
        0.01,
        march,
    );
    let towards = slanted(into, turn);
    iris_scattered_once(maps, &frame(), tissue, &surface, towards, 0.0, march)
}

#[test]
fn a_flat_iris_scatters_once_as_its_layers_do() {
    for (pigment, density) in [(IrisPigment::BLUE, 0.4), (IrisPigment::BROWN, 0.7)] {
        let tissue = IrisTissue::new(&pigment);
        let maps = flat(0.45, density as f32);
        for (into, out, turn) in [(1.0, 1.0, 0.0), (0.7, 0.9, 2.0), (0.8, 0.6, 4.0)] {
            let border = tissue.border + tissue.border_melanin * density;
            let sines = f64::sqrt((1.0 - into * into) * (1.0 - out * out));
            let cosine = -(into * out + sines * f64::cos(turn));
            let phase = |share: DVec3| {
                let of = |share: f64| {
                    let sideways = (1.0 - share) * BUNDLE_SIDEWAYS;
                    phase_mix(cosine, share, sideways, BUNDLE_SCALED_COSINE)
                };
                DVec3::new(of(share.x), of(share.y), of(share.z))
            };
            let mean = |above: DVec3, extinction: DVec3, scattering: DVec3, thickness: f64| {
                layer_reflect_once(above, extinction, scattering, thickness, into, out)
            };
            let first = mean(
                DVec3::ZERO,
                border,
                tissue.border_scattering,
                BORDER_LAYER_MM,
            );
            let depth = 0.45 - BORDER_LAYER_MM;
            let above = border * BORDER_LAYER_MM;
            let second = mean(above, tissue.stroma, tissue.stroma_scattering, depth);
            let both = first * phase(tissue.border_fibrils) + second * phase(tissue.stroma_fibrils);
            // A BRDF is for irradiance of the surface.
            let exact = tissue.weights * both * into;
            for march in [&IRIS_MARCH_FAST, &IRIS_MARCH_FULL] {
                let ours = once(&maps, &tissue, [into, out, turn], march);
                // Thickness and melanin are half floats.
                let off = (ours - exact).abs().max_element();
                assert!(off < 5e-6, "{march:?}: {ours} {exact}");
            }
        }
    }
}

/// What of a beam at this cosine is sent back into the aqueous' cone, over what a white surface would.
fn sent_back(
    maps: &IrisMaps,
    tissue: &IrisTissue,
    again: impl Fn(f64) -> DVec3,
    into: f64,
) -> DVec3 {
    const N: usize = 24;
    let mut sum = DVec3::ZERO;
    for j in 0..N {
        // Even steps of the flux.
        let least = AQUEOUS_COSINE * AQUEOUS_COSINE;
        let out = (least + (1.0 - least) * (j as f64 + 0.5) / N as f64).sqrt();
        for k in 0..8 {
            let turn = (k as f64 + 0.5) * core::f64::consts::TAU / 8.0;
            let factor = core::f64::consts::PI / into / 8.0;
            sum += once(maps, tissue, [into, out, turn], &IRIS_MARCH_FAST) * factor;
        }
        sum += again(out);
    }
    sum / N as f64
}

#[test]
fn once_and_again_are_what_walks_bring_back() {
    // The cosines at which light arrives inside an eye, in front of it and from far aside; both sums with the collagen's real phase functions. What is
    // left is what two moments of those leave (straight back, most of all in thin dark layers), and one path in
    // place of two.
    for (pigment, density) in [
        (IrisPigment::BLUE, 0.4),
        (IrisPigment::GREEN, 0.5),
        (IrisPigment::HAZEL, 0.5),
        (IrisPigment::BROWN, 0.7),
    ] {
        let thickness = 0.45;
        let tissue = IrisTissue::new(&pigment);
        let maps = flat(thickness as f32, density as f32);
        let [_, table] = IrisReflectanceTable::seen(&pigment, 64, 32);
        for into in [1.0, 0.8, 0.68] {
            let few = Wavelengths::<3>::new();
            let walked = DVec3::from(matched(&pigment, &few).map(|at| {
                let layers = forward_layers(&pigment, thickness, density, &at);
                let illumination = Illumination::Beam(into);
                let walk = random_walk_within(&layers, illumination, AQUEOUS_COSINE, 400_000, 5);
                walk.mean / (1.0 - AQUEOUS_COSINE * AQUEOUS_COSINE)
            }));
            let walked = tissue.weights * walked;
            let again =
                |out: f64| DVec3::from(table.sample(iris_path(thickness, -into, out), density));
            let ours = sent_back(&maps, &tissue, again, into);
            let error = (ours - walked).abs().max_element() / walked.max_element();
            let allowed = if into == 1.0 { 0.13 } else { 0.08 };
            assert!(error < allowed, "{into}: {ours} {walked}");
        }
    }
}

/// Strands of the stroma 0.1 mm wide and 0.3 mm apart, at a place across them (mm), mm as dense as the mean.
fn strands(x: f64) -> f64 {
    let from_middle = ((x / PERIOD_MM).rem_euclid(1.0) - 0.5).abs() * PERIOD_MM;
    mix(0.66, 0.12, ((from_middle - 0.03) / 0.04).clamp(0.0, 1.0))
}
const PERIOD_MM: f64 = 0.3;

/// Light that comes back of a stroma without absorption after more than one scattering, into the aqueous' cone, over what falls on it: at
/// the middle of strands and of the gaps between them. Straight in, scattered alike in all directions; `mean` per mm of mean density.
fn walked_again(stroma: impl Fn(f64) -> f64, mean: f64, walks: u32) -> [f64; 2] {
    use rand::{RngExt, SeedableRng};
    let most = 4.0 * mean;
    let mut rng = rand_pcg::Pcg64::seed_from_u64(7);
    let mut found = [0.0; 2];
    for _ in 0..walks {
        let (mut x, mut z) = (rng.random::<f64>() * PERIOD_MM, 0.0);
        let (mut aside, mut down) = (0.0, 1.0_f64);
        let mut times = 0;
        // By steps to what may scatter, which does by its density (Woodcock 1965).
        loop {
            let step = -(1.0 - rng.random::<f64>()).ln() / most;
            (x, z) = (x + aside * step, z + down * step);
            if z < 0.0 {
                let leaves = (x - aside * (z / down)) / PERIOD_MM;
                let place = (leaves.rem_euclid(1.0) - 0.5).abs();
                if times > 1 && -down > AQUEOUS_COSINE {
                    // A thirtieth of the period about either.
                    let parts = [place < 1.0 / 60.0, place > 0.5 - 1.0 / 60.0];
                    for (sum, is_there) in found.iter_mut().zip(parts) {
                        *sum += f64::from(u8::from(is_there));
                    }
                }
                break;
            }
            let Some(density) = stroma_density(z, stroma(x), &frame()) else {
                break;
            };
            if rng.random::<f64>() * most < density * mean {
                times += 1;
                down = 2.0 * rng.random::<f64>() - 1.0;
                let turn = rng.random::<f64>() * core::f64::consts::TAU;
                aside = (1.0 - down * down).sqrt() * turn.cos();
            }
        }
    }
    found.map(|sum| sum * 30.0 / f64::from(walks))
}

#[test]
fn what_is_scattered_again_spreads_as_far_as_walks_between_strands_do() {
    // That of green light, and of blue.
    for mean in [1.0, 2.0] {
        let even: Vec<[f64; 2]> = (0..16)
            .map(|i| {
                let stroma = 0.05 * f64::from(i) + 1e-6;
                let both = walked_again(|_| stroma, mean, 300_000);
                [stroma, 0.5 * (both[0] + both[1])]
            })
            .collect();
        let of_even = |stroma: f64| {
            let at = (stroma / 0.05).clamp(0.0, 14.999);
            let (low, high) = (even[at as usize][1], even[at as usize + 1][1]);
            mix(low, high, at.fract())
        };
        let walked = walked_again(strands, mean, 2_000_000);
        // The same strands in a map, and what its smoothed levels say of their middles and gaps.
        let (width, height) = (2048, 512);
        let radius = 3.5;
        let round = core::f64::consts::TAU * radius;
        let count = (round / PERIOD_MM).round();
        let texel = |i: usize| {
            let turns = ((i % width) as f64 + 0.5) / width as f64;
            [
                (BORDER_LAYER_MM + strands(turns * count * PERIOD_MM)) as f32,
                0.0,
                0.0,
                0.0,
            ]
        };
        let texels = (0..width * height).map(texel).collect();
        let map = MapView::new(&chain((width, height), texels), true);
        let modulation = |[strand, gap]: [f64; 2]| (strand - gap) / (strand + gap);
        let smoothed = |over_mm: f64| {
            let lod = (over_mm / iris_texel_mm(height as f64, 0.0, &frame())).log2();
            let v = (radius - frame().pupil) / frame().width();
            // Of all strands, as each lies otherwise among the texels.
            modulation([0.5, 0.0].map(|part| {
                let all = (0..count as u32).map(|strand| {
                    let uv = DVec2::new((f64::from(strand) + part) / count, v);
                    of_even(iris_texel(&map, &frame(), uv, lod).thickness - BORDER_LAYER_MM)
                });
                all.sum::<f64>()
            }))
        };
        let walks = modulation(walked);
        let off = |over_mm: f64| (smoothed(over_mm) - walks).abs();
        let [half, ours, twice] = [0.5, 1.0, 2.0].map(|times| off(times * IRIS_SPREAD_MM));
        println!(
            "{mean}: {walks:.3} by walks; off by {ours:.3}, half as far by {half:.3}, twice by {twice:.3}"
        );
        // Levels of a map halve: it is the one that is nearest.
        assert!(
            ours < half && ours < twice && ours < 0.25,
            "{half} {ours} {twice}"
        );
    }
}

/// Gonioscopy: light from the chamber's angle is reflected totally at the cornea. The usual eye shows nothing past the root of its iris from
/// any side, no healthy one more than the next 0.7 mm; without refraction it lies open.
#[test]
fn a_cornea_hides_the_angle() {
    let mut stream = crate::tissue::noise::HashStream::new(7, 1);
    // By how much (a share of what healthy eyes have) eyes are drawn beside the usual one.
    let mut outermost = |n_cornea: f64, n_aqueous: f64, eyes: usize, varied: f64| {
        let mut most = f64::MIN;
        for _ in 0..eyes {
            let mut about =
                |usual: f64, off: f32| usual + varied * f64::from(stream.range(-off, off));
            let limbus = about(5.85, 0.3);
            let anterior = DVec2::new(about(7.8, 0.65), about(0.75, 0.18));
            let posterior = DVec2::new(anterior.x - about(1.4, 0.15), anterior.y - 0.025);
            let thickness = about(0.55, 0.1);
            if anterior.x / anterior.y.sqrt() < 1.02 * limbus
                || posterior.x / posterior.y.sqrt() < 1.02 * limbus
            {
                continue;
            }
            let depth = about(3.6, 0.5);
            let iris = IrisFrame {
                root: limbus + 0.2,
                limbus,
                cone: about(0.146, 0.116),
                bow: about(0.0, 0.12),
                pupil: about(1.75, 1.25),
                ..frame()
            };
            for degrees in (0..90).step_by(6) {
                let (sin, cos) = f64::from(degrees).to_radians().sin_cos();
                let direction = DVec3::new(sin, 0.0, cos);
                for i in -24..=24 {
                    for j in 0..=24 {
                        let entry = DVec2::new(f64::from(i), f64::from(j)) * (limbus / 24.0);
                        if entry.length() > limbus {
                            continue;
                        }
                        let z = conicoid_depth(entry.length(), anterior);
                        let origin = entry.extend(z) - direction * 60.0;
                        let trace = cornea_trace(
                            origin, direction, anterior, posterior, thickness, n_cornea, n_aqueous,
                            depth,
                        );
                        // What stands behind the bulge of the cornea is not the first that is met.
                        if trace.valid < 0.5 || trace.entry.truncate().distance(entry) > 1e-3 {
                            continue;
                        }
                        let at = iris_landing(trace.point.truncate(), trace.direction, &iris);
                        let place = iris_place(at, &iris);
                        most = most.max((place.uv.y - 1.0) / place.dv);
                    }
                }
            }
        }
        most
    };
    let usual = outermost(1.376, 1.336, 1, 0.0);
    let healthy = outermost(1.376, 1.336, 60, 1.0);
    let none = outermost(1.0, 1.0, 1, 0.0);
    println!(
        "seen past the root: {usual:.2} mm, of healthy eyes {healthy:.2}, unrefracted {none:.1}"
    );
    assert!(
        usual < 0.0 && healthy < 0.7 && none > 2.0,
        "{usual} {healthy} {none}"
    );
}

/// Depth (mm) of a conicoid's surface (R, p) this far from its axis.
fn conicoid_depth(r: f64, surface: DVec2) -> f64 {
    let left = surface.x * surface.x - surface.y * r * r;
    r * r / (surface.x + left.max(0.0).sqrt())
}
