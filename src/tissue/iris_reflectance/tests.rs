use super::*;
use crate::optics::output::linear_to_srgb;

const THICKNESS: f64 = 0.45;

/// The same without blood.
fn without_blood(pigment: IrisPigment) -> IrisPigment {
    IrisPigment {
        stroma_blood_fraction: 0.0,
        ..pigment
    }
}

fn show(name: &str, rgb: [f64; 3]) -> [f64; 3] {
    let encoded = linear_to_srgb(glam::DVec3::from_array(rgb)) * 255.0;
    println!(
        "{name}: linear {:.3} {:.3} {:.3}, sRGB {:.0} {:.0} {:.0}",
        rgb[0], rgb[1], rgb[2], encoded.x, encoded.y, encoded.z
    );
    rgb
}

#[test]
fn a_blue_iris_is_blue_by_scattering() {
    // As dense as the border layer of pale irises is outside the collarette.
    const USUAL: f64 = 0.2;
    let bloodless = without_blood(IrisPigment::BLUE);
    for path in [0.2, THICKNESS, 0.8] {
        let [r, g, b] = show("blue", iris_reflectance(&bloodless, path, USUAL));
        assert!(b > g && g > r, "blue-grey order");
        // Where the stroma is thick its fibres are white.
        let [r, g, b] = show(
            "with blood",
            iris_reflectance(&IrisPigment::BLUE, path, USUAL),
        );
        assert!((b > g && g > r) == (path < 0.5));
    }
    let [[r, g, b], _] = iris_reflectance_seen(&bloodless, THICKNESS, USUAL);
    println!("seen: {r} {g} {b}");
    // The calibration's aim: a pale iris of photographs.
    assert!((r - 0.130).abs() < 0.01 && (g - 0.166).abs() < 0.01 && (b - 0.218).abs() < 0.01);
    // Blood makes it greyer.
    let [[red, green, blue], _] = iris_reflectance_seen(&IrisPigment::BLUE, THICKNESS, USUAL);
    assert!(red > 0.92 * r && green < 0.92 * g && blue < 0.87 * b && blue > 1.25 * red);
    let none = IrisPigment {
        stroma_blood_fraction: 0.0,
        stroma_melanin_fraction: 0.0,
        border_layer_melanin_fraction: 0.0,
        eumelanin_ratio: 0.5,
    };
    let [r, g, b] = iris_reflectance(&none, THICKNESS, 1.0);
    assert!(
        b > 1.25 * g && g > 1.15 * r,
        "no pigment at all is the bluest"
    );
}

#[test]
fn a_brown_iris_is_dark_and_warm() {
    for density in [0.3, 0.5, 1.0] {
        let [r, g, b] = show(
            "brown",
            iris_reflectance(&IrisPigment::BROWN, THICKNESS, density),
        );
        assert!(r > 1.05 * g && g > 1.2 * b);
        assert!(g < 0.09 && r > 0.015);
    }
    let [r, g, b] = iris_reflectance(&IrisPigment::BROWN, THICKNESS, 0.5);
    assert!(
        r > 1.3 * g && g > 1.8 * b,
        "brown where the border layer is half dense"
    );
}

#[test]
fn green_and_hazel_lie_between() {
    let seen = |pigment: &IrisPigment| iris_reflectance_seen(pigment, THICKNESS, 0.5)[0];
    let [r, g, b] = show("green", seen(&IrisPigment::GREEN));
    assert!(
        g > 1.04 * r && g > 1.05 * b,
        "green is the strongest channel"
    );
    let green = g;
    let [r, g, b] = show("hazel", seen(&IrisPigment::HAZEL));
    assert!(r > g && g > 1.5 * b && r < 1.3 * g, "yellow-brown");
    let brown = seen(&IrisPigment::BROWN)[1];
    assert!(green > g && g > brown);
}

#[test]
fn pheomelanin_needs_the_printed_constant_to_make_green() {
    use crate::tissue::melanin::{
        PHEOMELANIN_DILUTE, PHEOMELANIN_FRANCOIS, pheomelanin_absorption,
    };
    // Diffuse light crosses the half-dense border layer twice, on average at 60°: what is left
    // of the blue against the red?
    let passes = |constant: f64| {
        let melanin = 0.5 * IrisPigment::GREEN.border_layer_melanin_fraction;
        let path = 2.0 * 2.0 * BORDER_LAYER_MM;
        let through = |nm| (-melanin * path * pheomelanin_absorption(nm, constant)).exp();
        through(460.0) / through(610.0)
    };
    // A blue stroma has that much more blue than red: the printed constant turns that around,
    // a tenth of it leaves it.
    let [r, _, b] = iris_reflectance(&IrisPigment::BLUE, 0.2, 0.0);
    println!("blue over red {}", b / r);
    assert!(b / r > 1.4 && b / r * passes(PHEOMELANIN_FRANCOIS) < 1.0);
    assert!(passes(PHEOMELANIN_DILUTE) > 0.9);
}

#[test]
fn more_stroma_is_brighter_and_more_melanin_darker() {
    let at = |pigment: &IrisPigment, path, density| iris_reflectance(pigment, path, density)[1];
    // Under blood that is thick enough the green channel, which weighs red negatively, grows no more.
    let classes = [IrisPigment::BLUE, IrisPigment::GREEN, IrisPigment::HAZEL];
    for pigment in classes {
        for i in 1..20 {
            let path = f64::from(i) * 0.12;
            let [thin, thick] =
                [path - 0.12, path].map(|path| iris_reflectance_spectrum(&pigment, path, 0.5));
            // Where blood lets nothing through, not to the last bit.
            assert!(
                thin.iter()
                    .zip(&thick)
                    .all(|(thin, thick)| thick > &(thin - 1e-12))
            );
            assert!(thick.iter().sum::<f64>() > thin.iter().sum());
        }
    }
    for pigment in classes.map(without_blood) {
        for i in 1..20 {
            let path = f64::from(i) * 0.12;
            assert!(at(&pigment, path, 0.5) > at(&pigment, path - 0.12, 0.5));
            let density = f64::from(i) * 0.05;
            assert!(at(&pigment, THICKNESS, density) < at(&pigment, THICKNESS, density - 0.05));
        }
    }
}

#[test]
fn the_table_is_the_function() {
    let table = IrisReflectanceTable::new(&IrisPigment::GREEN, 64, 32);
    assert_eq!(table.rgb().len(), table.width() * table.height());
    let mut worst: f64 = 0.0;
    for i in 1..50 {
        for j in 1..50 {
            let (path, density) = (0.05 * f64::from(i), 0.02 * f64::from(j));
            let exact = iris_reflectance(&IrisPigment::GREEN, path, density);
            let read = table.sample(path, density);
            worst = (0..3).fold(worst, |w, c| w.max((read[c] - exact[c]).abs()));
        }
    }
    println!("64 × 32 table: worst error {worst:.1e}");
    // A quarter of the curvature of R = Sd/(1 + Sd) over 0.04 mm; half an 8-bit step is 2e-3.
    assert!(worst < 2e-3, "{worst}");
}

#[test]
fn a_texel_is_the_function_at_its_centre() {
    for pigment in [IrisPigment::BLUE, IrisPigment::BROWN] {
        let table = IrisReflectanceTable::new(&pigment, 5, 3);
        let many = IrisReflectanceTable::many_flux(&pigment, 5, 3);
        for row in 0..3 {
            for column in 0..5 {
                let path = STROMA_PATH_MAX_MM * (f64::from(column) + 0.5) / 5.0;
                let density = ((f64::from(row) + 0.5) / 3.0).powi(2);
                let exact = iris_reflectance(&pigment, path, density);
                assert_eq!(table.rgb()[(row * 5 + column) as usize], exact);
                let exact = iris_reflectance_many_flux(&pigment, path, density);
                assert_eq!(many.rgb()[(row * 5 + column) as usize], exact);
            }
        }
    }
}

#[test]
fn eight_wavelengths_are_as_good_as_all() {
    use crate::tissue::spectrum::spectrum_to_linear_srgb;
    for pigment in [
        IrisPigment::BLUE,
        IrisPigment::GREEN,
        IrisPigment::HAZEL,
        IrisPigment::BROWN,
    ] {
        // Blood has bands: below.
        let pigment = without_blood(pigment);
        for path in [0.02, THICKNESS, 2.5] {
            for density in [0.0, 0.5, 1.0] {
                let all = iris_reflectance_spectrum(&pigment, path, density);
                let all = spectrum_to_linear_srgb(&all);
                let few = iris_reflectance(&pigment, path, density);
                for channel in 0..3 {
                    // A thirtieth of an 8-bit step at the dark end of sRGB, where steps are
                    // smallest.
                    let off = (few[channel] - all[channel].clamp(0.0, 1.0)).abs();
                    assert!(off < 1e-5, "{pigment:?} {path} {density}: {off:e}");
                }
            }
        }
    }
}

/// Linear sRGB by the whole spectrum, and ΔE2000 of another colour from it.
fn off_from_all(pigment: &IrisPigment, path: f64, density: f64, few: [f64; 3]) -> f64 {
    use crate::tissue::colour_difference::{delta_e_2000, linear_srgb_to_lab};
    use crate::tissue::spectrum::spectrum_to_linear_srgb;
    let all = spectrum_to_linear_srgb(&iris_reflectance_spectrum(pigment, path, density));
    delta_e_2000(linear_srgb_to_lab(all), linear_srgb_to_lab(few))
}

#[test]
fn blood_is_kept_by_few_wavelengths() {
    let three = Wavelengths::<3>::new();
    for pigment in [
        IrisPigment::BLUE,
        IrisPigment::GREEN,
        IrisPigment::HAZEL,
        IrisPigment::BROWN,
    ] {
        let (tissue, few) = (matched(&pigment, &three), TissueCoefficients::few(&three));
        let mut worst = [0.0_f64; 2];
        for path in [0.1, 0.2, 0.3, THICKNESS, 0.6, 0.9] {
            for density in [0.0, 0.5, 1.0] {
                let eight = iris_reflectance(&pigment, path, density);
                let off = off_from_all(&pigment, path, density, eight);
                worst[0] = worst[0].max(off);
                let of = |tissue: &[TissueCoefficients; 3]| {
                    let at = |t: &TissueCoefficients| reflectance_of(&pigment, path, density, t);
                    three.linear_srgb(&tissue.each_ref().map(at))
                };
                let off = off_from_all(&pigment, path, density, of(&tissue));
                worst[1] = worst[1].max(off);
                if path == THICKNESS && density == 0.0 {
                    // Matched there, and else it is not.
                    assert!(off < 1e-3, "{pigment:?}: {off:e}");
                    let unmatched = off_from_all(&pigment, path, density, of(&few));
                    assert!(unmatched > 0.5, "{pigment:?}: {unmatched}");
                }
            }
        }
        println!(
            "ΔE2000, at most: eight wavelengths {:.2}, three {:.2}",
            worst[0], worst[1]
        );
        assert!(worst[0] < 0.8 && worst[1] < 3.0, "{pigment:?}: {worst:?}");
    }
}

#[test]
fn many_fluxes_are_brighter_than_two_by_what_two_miss() {
    use crate::tissue::iris_layers::reduced_layers;
    use crate::tissue::many_flux::stack_many_flux;
    let dense = IrisPigment {
        stroma_melanin_fraction: 0.05,
        border_layer_melanin_fraction: 0.42,
        eumelanin_ratio: 0.05,
        stroma_blood_fraction: 0.0,
    };
    let paler = IrisPigment {
        border_layer_melanin_fraction: 0.02,
        ..without_blood(IrisPigment::BLUE)
    };
    for (pigment, two_miss) in [
        (IrisPigment::BLUE, 0.029),
        (IrisPigment::BROWN, 0.096),
        (paler, 0.062),
        (dense, 0.083),
    ] {
        let many = iris_reflectance_many_flux(&pigment, THICKNESS, 0.5);
        // Green channel: measured with 16 nodes those without blood, with four the others.
        let two = iris_reflectance(&pigment, THICKNESS, 0.5);
        assert!(
            (1.0 - two[1] / many[1] - two_miss).abs() < 0.01,
            "{two:?} {many:?}"
        );
        let exact = AT.1.each_ref().map(|tissue| {
            stack_many_flux::<16>(&reduced_layers(&pigment, THICKNESS, 0.5, tissue)).reflectance
        });
        for (many, exact) in many.iter().zip(colour(&exact)) {
            // Four nodes: 3.2e-4 at most.
            assert!((many - exact).abs() < 4e-4, "{many} {exact}");
        }
    }
}

#[test]
fn senseless_input_stays_a_colour() {
    let odd = IrisPigment {
        stroma_blood_fraction: f64::NAN,
        stroma_melanin_fraction: f64::NAN,
        border_layer_melanin_fraction: 7.0,
        eumelanin_ratio: -1.0,
    };
    for (path, density) in [
        (f64::NAN, 0.5),
        (-1.0, f64::NAN),
        (f64::INFINITY, 2.0),
        (0.0, 0.0),
    ] {
        for colour in [
            iris_reflectance(&odd, path, density),
            iris_reflectance_many_flux(&odd, path, density),
        ] {
            assert!(colour.iter().all(|c| (0.0..=1.0).contains(c)), "{colour:?}");
        }
    }
    assert_eq!(
        IrisReflectanceTable::new(&IrisPigment::BLUE, 0, 0)
            .rgb()
            .len(),
        1
    );
    assert!(IrisReflectanceTable::new(&IrisPigment::BLUE, 1, 1).sample(f64::NAN, 9.0)[0] > 0.0);
}

#[test]
fn stromas_grown_by_steps_are_those_of_their_thickness() {
    for pigment in [IrisPigment::BLUE, IrisPigment::BROWN] {
        let [width, height] = IRIS_TABLE;
        let [all, again] = IrisReflectanceTable::seen(&pigment, width, height);
        for (column, row) in [
            (0, 0),
            (width / 2, 3),
            (width - 1, 0),
            (width - 1, height - 1),
        ] {
            let path = STROMA_PATH_MAX_MM * (column as f64 + 0.5) / width as f64;
            let root = (row as f64 + 0.5) / height as f64;
            let alone = iris_reflectance_seen(&pigment, path, root * root);
            for (table, one) in [&all, &again].into_iter().zip(alone) {
                let found = table.rgb()[row * width + column];
                for (a, b) in found.iter().zip(one) {
                    // Sixty-four steps, each of whose slices is good to 1e-7 of its depth.
                    assert!((a - b).abs() < 1e-6, "{column} {row}: {a} {b}");
                }
            }
        }
    }
}
