//! The upper lashes as what stands before the globe, in what it mirrors and in the light that falls on it: a comb on a sheet
//! that curls up before the lid. Head frame, millimetres. Twin: `shaders/lib/lash_comb.wgsl`.

use super::mix;
use crate::optics::smoothstep::smoothstep;
use glam::DVec3;

/// They are a comb of their own, with the number of those that are drawn and not their places (choices by
/// the look of macro photographs). How much they rise (1/mm: their height over the margin is this times the square of how far they stand
/// before it), how far they reach forward (mm), and how dark they are.
const LASH_CURL: f64 = 0.09;
const LASH_REACH_MM: f64 = 8.0;
pub const LASH_DARK: f64 = 0.8;
/// Their comb, rad/mm (three to a millimetre of lid), and the share of it that is lash.
const LASH_COMB: f64 = 19.0;
pub const LASH_SHARE: f64 = 0.29;

/// How much steeper than the lowest ray that meets the sheet a ray rises where half of the lashes that it crosses are there: not every lash
/// curls alike (a choice).
const LASH_EVEN: f64 = 0.45;

/// How far before the lid (mm) half of them end.
const LASH_HALF_MM: f64 = 0.75 * LASH_REACH_MM;

/// How steep the ray is, from a place `upper_gap` mm below the upper lid's margin, that half of the lashes that it crosses let pass: its rise
/// for each unit forward. Steeper ones meet all of them.
pub fn lash_rise(upper_gap: f64) -> f64 {
    let gap = upper_gap.max(0.0);
    let meets = (4.0 * LASH_CURL * gap + LASH_EVEN).sqrt();
    meets.max(LASH_CURL * LASH_HALF_MM + gap / LASH_HALF_MM)
}

/// Share of a ray in the unit direction `r`, from a place `x` mm aside and `upper_gap` mm below the upper lid's margin,
/// that they let pass where it is blurred by `near` mm at the place and `far` mm for each millimetre that it goes forward: what is
/// wider than the comb's teeth sees what they take in the mean.
pub fn lashes_left(x: f64, r: DVec3, upper_gap: f64, near: f64, far: f64) -> f64 {
    let forward = (-r.z).max(0.2);
    let rise = r.y / forward;
    let crosses = rise * rise - 4.0 * LASH_CURL * upper_gap.max(0.0);
    let reach = (rise - crosses.max(0.0).sqrt()) / (2.0 * LASH_CURL);
    let aside = x + r.x / forward * reach;
    let waves = 2.5 * (aside * 2.3).sin() + 1.7 * (aside * 5.1).sin();
    let comb = (aside * LASH_COMB + waves).sin();
    let steep = 1.0 + r.x.abs() / forward / crosses.max(0.01).sqrt();
    let turn = LASH_COMB * (near * steep + far * reach);
    let tooth = mix(
        LASH_SHARE,
        smoothstep(0.3, 0.95, comb),
        (-turn * turn).exp(),
    );
    let there = smoothstep(0.0, 2.0 * LASH_EVEN, crosses)
        * smoothstep(0.0, 0.3, rise)
        * (1.0 - smoothstep(0.5 * LASH_REACH_MM, LASH_REACH_MM, reach));
    1.0 - LASH_DARK * there * tooth
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ray is where the sheet is: its height over the margin is its curl times the square of how far it has come forward.
    #[test]
    fn the_comb_stands_on_its_sheet() {
        // Lashes of a comb that is seen sharply, at places whose rays meet the sheet at the same lash.
        for (rise, gap) in [(1.4_f64, 1.0_f64), (2.0, 0.5), (1.9, 2.2)] {
            let slant = 0.7;
            let r = DVec3::new(slant, rise, -1.0).normalize();
            let straight = DVec3::new(0.0, rise, -1.0).normalize();
            // Marched to the sheet.
            let steps = (0..400_000).map(|k| f64::from(k) * 2e-5);
            let meets = |far: &f64| far * rise - gap - LASH_CURL * far * far >= 0.0;
            let far = { steps }.find(meets).expect("it meets the sheet");
            for k in 0..40 {
                let x = 0.05 * f64::from(k);
                let (here, there) = (
                    lashes_left(x, r, gap, 0.0, 0.0),
                    lashes_left(x + slant * far, straight, gap, 0.0, 0.0),
                );
                assert!(
                    (here - there).abs() < 2e-3,
                    "{rise} {gap} {x}: {here} {there}"
                );
            }
        }
    }

    #[test]
    fn what_is_wider_than_the_comb_loses_its_share_and_what_rises_less_nothing() {
        let up = DVec3::new(0.1, 1.6, -1.0).normalize();
        let mean = |near: f64, far: f64| {
            let all = (0..4000).map(|k| lashes_left(0.005 * f64::from(k), up, 0.8, near, far));
            all.sum::<f64>() / 4000.0
        };
        assert!((mean(0.3, 0.0) - (1.0 - LASH_DARK * LASH_SHARE)).abs() < 1e-6);
        assert!((mean(0.0, 0.4) - (1.0 - LASH_DARK * LASH_SHARE)).abs() < 1e-6);
        // The sharp comb takes as much in the mean.
        assert!(
            (mean(0.0, 0.0) - mean(0.3, 0.0)).abs() < 0.02,
            "{}",
            mean(0.0, 0.0)
        );
        let dark = (0..400).map(|k| lashes_left(0.01 * f64::from(k), up, 0.8, 0.0, 0.0));
        assert!(dark.fold(1.0, f64::min) < 0.25);
        for rise in [-1.0, 0.0, 0.4] {
            let low = DVec3::new(0.0, rise, -1.0).normalize();
            assert_eq!(lashes_left(0.3, low, 2.0, 0.0, 0.0), 1.0);
        }
    }

    /// The step that stands for the comb in the sky's light takes as much of an even sky before a level place.
    #[test]
    fn the_step_takes_what_the_comb_does() {
        for gap in [0.0, 0.3, 1.0, 2.0, 3.5, 5.0, 7.0, 9.0] {
            let (mut comb, mut step, mut all) = (0.0, 0.0, 0.0);
            for i in 0..300 {
                for j in 0..60 {
                    // In the plane of the normal and the vertical, and across it.
                    let a = (f64::from(i) + 0.5) / 300.0 * core::f64::consts::PI
                        - core::f64::consts::FRAC_PI_2;
                    let b = (f64::from(j) + 0.5) / 60.0 * 2.4 - 1.2;
                    let r = DVec3::new(b.sin(), b.cos() * a.sin(), -b.cos() * a.cos());
                    let weight = b.cos() * -r.z;
                    let passed = lashes_left(0.0, r, gap, 0.3, 0.3);
                    comb += weight * passed;
                    let behind = r.y > -r.z * lash_rise(gap);
                    step += weight
                        * if behind {
                            1.0 - LASH_DARK * LASH_SHARE
                        } else {
                            1.0
                        };
                    all += weight;
                }
            }
            let (comb, step) = (comb / all, step / all);
            println!("{gap}: {comb:.4} {step:.4}");
            // 0.0022 at the most.
            assert!((comb - step).abs() < 0.004, "{gap}: {comb} {step}");
        }
    }
}
