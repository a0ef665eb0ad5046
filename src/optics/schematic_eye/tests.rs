use super::dispersion::OcularMedium::{Aqueous, Cornea, Lens, Vitreous};
use super::dispersion::{dispersed, navarro_index};
use super::*;
use crate::optics::reference::paraxial::{Meridian, paraxial};
use proptest::prelude::*;

fn refraction(eye: &SchematicEye) -> f64 {
    paraxial(eye, Meridian::Vertical).refraction_d
}

#[test]
fn indices_are_those_printed_for_lasers() {
    // Escudero-Sanz & Navarro 1999, table 2: cornea, aqueous, lens, vitreous; four decimals. The
    // coefficients of Herzberger's formula reach them to one and a half units of the last.
    let table = [
        (458.0, [1.3828, 1.3445, 1.4292, 1.3428]),
        (543.0, [1.3777, 1.3391, 1.4222, 1.3377]),
        (589.3, [1.376, 1.3374, 1.42, 1.336]),
        (632.8, [1.3747, 1.336, 1.4183, 1.3347]),
    ];
    for (nm, printed) in table {
        for (medium, expected) in [Cornea, Aqueous, Lens, Vitreous].into_iter().zip(printed) {
            let n = navarro_index(medium, nm);
            assert!((n - expected).abs() < 1.6e-4, "{nm} {medium:?} {n}");
        }
    }
    // It interpolates: the nodes themselves, as far as the eight decimals of the coefficients
    // (times 1/(λ² − λ₀²)² ≤ 90) go.
    for (nm, node) in [
        (365.0, 1.3593),
        (486.1, 1.3422),
        (656.3, 1.3354),
        (1014.0, 1.3278),
    ] {
        assert!((navarro_index(Aqueous, nm) - node).abs() < 3e-5, "{nm}");
    }
    assert_eq!(dispersed(Lens, 1.42, 589.3, 589.3), 1.42);
    let near = dispersed(Lens, navarro_index(Lens, 589.3), 589.3, 450.0);
    assert!((near - navarro_index(Lens, 450.0)).abs() < 1e-15);
}

#[test]
fn colour_changes_refraction_as_measured() {
    // Thibos 1992, 1.68524 − 0.63346/(λ − 0.21410), as a difference from 589.3 nm. Navarro's
    // dispersion was adjusted to older data: 0.01 D from 550 to 700 nm, 0.12 D at 450, 0.37 at 400.
    let thibos = |nm: f64| 0.63346 * (1.0 / (0.5893 - 0.21410) - 1.0 / (1e-3 * nm - 0.21410));
    let change = |eye: &dyn Fn(f64) -> SchematicEye, nm: f64| {
        refraction(&eye(nm)) - refraction(&eye(SODIUM_NM))
    };
    let navarro = |nm| SchematicEye::navarro(0.0, nm);
    let atchison = |nm| SchematicEye::atchison(0.0, nm);
    for (nm, room) in [
        (400.0, 0.40),
        (450.0, 0.13),
        (500.0, 0.035),
        (550.0, 0.01),
        (650.0, 0.01),
        (700.0, 0.01),
    ] {
        for eye in [
            &navarro as &dyn Fn(f64) -> SchematicEye,
            &SchematicEye::escudero_navarro,
            &SchematicEye::le_grand,
        ] {
            let got = change(eye, nm);
            assert!(
                (got - thibos(nm)).abs() < room,
                "{nm}: {got} {}",
                thibos(nm)
            );
        }
        println!(
            "{nm} nm: Thibos {:+.3} D, Navarro {:+.3}, Gullstrand {:+.3}, Atchison {:+.3}, Liou–Brennan {:+.3}",
            thibos(nm),
            change(&navarro, nm),
            change(&SchematicEye::gullstrand, nm),
            change(&atchison, nm),
            change(&SchematicEye::liou_brennan, nm)
        );
    }
    // Water's dispersion, Liou & Brennan's, is too little.
    let span = |eye: &dyn Fn(f64) -> SchematicEye| change(eye, 700.0) - change(eye, 450.0);
    assert!(
        (span(&SchematicEye::liou_brennan) / (thibos(700.0) - thibos(450.0)) - 0.55).abs() < 0.05
    );
}

#[test]
fn navarro_accommodates_by_what_it_says() {
    // The formulas aim at the stimulus of measured lenses, not at the last digit: within 0.5 D.
    for a in 0..=10 {
        let a = f64::from(a);
        let got = -refraction(&SchematicEye::navarro(a, SODIUM_NM));
        println!("A = {a} D: refraction −{got:.3} D");
        assert!((got - a).abs() < 0.55, "{a}: {got}");
        let length = SchematicEye::navarro(a, SODIUM_NM).axial_length_mm();
        assert!((length - 24.003_98).abs() < 1e-12);
    }
    assert_eq!(
        SchematicEye::navarro(-3.0, 555.0),
        SchematicEye::navarro(0.0, 555.0)
    );
    assert_eq!(
        SchematicEye::navarro(f64::NAN, 555.0),
        SchematicEye::navarro(0.0, 555.0)
    );
}

#[test]
fn atchison_s_myopes_are_as_myopic_as_they_say() {
    // The vitreous is linear in the refraction, the optics are not: 0.35 D of 5, 1.1 of 10, and the
    // refraction counts at the spectacles, 12 mm away, as the model is fitted to.
    for (sr, room) in [(0.0, 0.03), (-2.0, 0.1), (-5.0, 0.1), (-10.0, 0.2)] {
        let cornea = refraction(&SchematicEye::atchison(sr, PHOTOPIC_NM));
        let spectacle = cornea / (1.0 + 0.012 * cornea);
        println!("Atchison {sr} D: {cornea:.3} D at the cornea, {spectacle:.3} at the spectacle");
        assert!((spectacle - sr).abs() < room, "{sr} {spectacle}");
    }
}

#[test]
fn the_gradient_lenses_are_continuous() {
    // What the two halves say in the plane where they meet, and at the poles (six decimals).
    for eye in [
        SchematicEye::liou_brennan(PHOTOPIC_NM),
        SchematicEye::atchison(0.0, PHOTOPIC_NM),
    ] {
        let middle = &eye.interfaces[4];
        let (front, back) = (middle.front, middle.back);
        for (x, y) in [(0.0, 0.0), (1.5, -2.0)] {
            let p = DVec3::new(x, y, middle.placed.vertex.z);
            assert!((front.at(p) - back.at(p)).abs() < 1e-6);
        }
        let front_pole = eye.interfaces[3].back.at(eye.interfaces[3].placed.vertex);
        let back_pole = eye.interfaces[5].front.at(eye.interfaces[5].placed.vertex);
        assert!((front_pole - back_pole).abs() < 2e-6);
    }
}

#[test]
fn a_narrow_distant_pencil_lands_on_the_fovea() {
    for eye in [
        SchematicEye::navarro(0.0, SODIUM_NM),
        SchematicEye::escudero_navarro(GREEN_NM),
        SchematicEye::le_grand(SODIUM_NM),
        SchematicEye::liou_brennan(PHOTOPIC_NM),
        SchematicEye::francois(1.336),
    ] {
        let ray = Ray::new(DVec3::new(0.01, 0.0, -5.0), DVec3::Z).unwrap();
        let at = eye.trace_to_retina(ray).ray().unwrap().origin;
        // 0.01 mm of pupil: spherical aberration of 1e-9 mm.
        assert!(at.truncate().length() < 3e-8, "{at}");
        assert!((at.z - eye.axial_length_mm()).abs() < 1e-12);
    }
}

#[test]
fn the_stop_stops() {
    let eye = SchematicEye::navarro(0.0, SODIUM_NM).with_stop_radius(1.5);
    let ray = |x: f64| Ray::new(DVec3::new(x, 0.0, -5.0), DVec3::Z).unwrap();
    // The stop looks 1.133 times larger.
    assert!(eye.trace_to_retina(ray(1.68)).ray().is_some());
    assert_eq!(
        eye.trace_to_retina(ray(1.72)),
        Traced::Blocked { surface: 2 }
    );
    let on_stop = eye.trace_to_stop(ray(1.68)).unwrap();
    assert!((on_stop.z - 3.6).abs() < 1e-15 && (on_stop.x - 1.68 / 1.133).abs() < 0.01);
}

proptest! {
    #[test]
    fn any_numbers_make_a_traceable_eye(
        a in prop::num::f64::ANY,
        nm in prop::num::f64::ANY,
        x in -4.0..4.0_f64,
        tilt in -1.5..1.5_f64,
    ) {
        for eye in [
            SchematicEye::navarro(a, nm),
            SchematicEye::escudero_navarro(nm),
            SchematicEye::atchison(a, nm),
            SchematicEye::liou_brennan(nm),
            SchematicEye::gullstrand(nm),
            SchematicEye::le_grand_accommodated(nm),
        ] {
            let constants = paraxial(&eye, Meridian::Horizontal);
            prop_assert!((40.0..100.0).contains(&constants.power_d));
            prop_assert!(constants.refraction_d.abs() < 40.0);
            let dir = DVec3::new(tilt.sin(), 0.0, tilt.cos());
            let ray = Ray::new(DVec3::new(x, 0.3, 3.0) - 8.0 * dir, dir).unwrap();
            if let Some(ray) = eye.trace_to_retina(ray).ray() {
                prop_assert!(ray.origin.is_finite() && ray.direction.is_finite());
            }
        }
    }
}
