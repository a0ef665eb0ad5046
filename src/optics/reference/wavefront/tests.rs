use super::*;
use crate::optics::defocus::PowerVector;
use crate::optics::ray_trace::Interface;
use crate::optics::reference::zernike::{paraxial_sphere_from_zernike, zernike_slopes};
use crate::optics::schematic_eye::{GREEN_NM, PHOTOPIC_NM, SODIUM_NM};
use crate::optics::surface::{Placed, Quadric};
use proptest::prelude::*;

fn on_axis(eye: &SchematicEye, diameter: f64) -> Wavefront {
    trace_wavefront(eye, diameter, ObjectPoint::default()).unwrap()
}

#[test]
fn tiny_pupils_have_the_paraxial_refraction() {
    for eye in [
        SchematicEye::navarro(0.0, SODIUM_NM),
        SchematicEye::navarro(6.0, 480.0),
        SchematicEye::gullstrand(SODIUM_NM),
        SchematicEye::atchison(-8.0, PHOTOPIC_NM),
        SchematicEye::liou_brennan(650.0),
    ] {
        let expected = paraxial(&eye, Meridian::Vertical).refraction_at_entrance_pupil_d();
        for vergence_d in [0.0, 3.0, -2.0, 20.0] {
            let object = ObjectPoint {
                vergence_d,
                ..ObjectPoint::default()
            };
            let wave = trace_wavefront(&eye, 0.2, object).unwrap();
            // Spherical aberration over 0.1 mm is 1e-3 D; a path of 24 mm rounds to 4e-12 µm, over
            // r²/(4√3) of 1.4e-3 mm²: 3e-9 D, and the gradient's step to 1e-4 D.
            let got = wave.power_vector().m_d;
            assert!(
                (got - expected - vergence_d).abs() < 2e-3,
                "{got} {expected} {vergence_d}"
            );
        }
        // Over a real pupil, by the curvature in its middle.
        let wave = on_axis(&eye, 4.0);
        let sphere = paraxial_sphere_from_zernike(&wave.coefficients_um, 2.0);
        assert!((sphere - expected).abs() < 2e-2, "{sphere} {expected}");
    }
}

#[test]
fn a_perfect_surface_has_a_perfect_wave() {
    // Descartes' ellipse with the stop at its vertex: nothing but rounding.
    let n = 1.336;
    let p = 1.0 - 1.0 / (n * n);
    let focus = n * 7.8 / (n - 1.0);
    let eye = SchematicEye {
        interfaces: vec![
            Interface::uniform(Placed::at(Quadric::conicoid(7.8, p), 0.0), 1.0, n),
            Interface::uniform(Placed::at(Quadric::PLANE, 3.0), n, n),
        ],
        stop: 1,
        retina: Placed::at(Quadric::conicoid(-12.0, 1.0), focus),
    };
    for diameter in [1.0, 4.0, 8.0] {
        let wave = on_axis(&eye, diameter);
        // Paths of 40 mm to a few 1e-14.
        assert!(
            wave.rms_um(0) < 1e-10 && wave.residual_um < 1e-10,
            "{wave:?}"
        );
    }
}

#[test]
fn coefficients_are_those_of_opticstudio() {
    // Ansys OpticStudio's Zernike standard coefficients (µm, 543 nm) of an astigmatic eye, from the
    // test data of visisipy (MREYE-LUMC). Its cornea is a biconic with Q = −0.2304 in both meridians,
    // which no quadric is; what does not turn with the meridian hardly notices.
    let conicoid = |r, q, z| Placed::at(Quadric::conicoid(r, 1.0 + q), z);
    let cornea = Placed::at(Quadric::toric(7.9487, 7.6967, 1.0 - 0.2304), 0.0);
    let eye = SchematicEye {
        interfaces: vec![
            Interface::uniform(cornea, 1.0, 1.3777),
            Interface::uniform(conicoid(6.2343, -0.1444, 0.5615), 1.3777, 1.3391),
            Interface::uniform(Placed::at(Quadric::PLANE, 3.9065), 1.3391, 1.3391),
            Interface::uniform(conicoid(10.2, -3.1316, 3.9065), 1.3391, 1.4222),
            Interface::uniform(conicoid(-5.4537, 0.0, 7.0765), 1.4222, 1.3377),
        ],
        stop: 2,
        retina: conicoid(-12.5, 0.033, 24.305),
    };
    // A stop of 1 mm radius; they scale by its paraxial image.
    let pupil = paraxial(&eye, Meridian::Vertical).entrance_pupil;
    let wave = on_axis(&eye, 2.0 * pupil.magnification);
    let c = wave.coefficients_um;
    for (name, ours, theirs, room) in [
        ("piston", c[0], 0.497_521_7, 3e-5),
        ("defocus", c[4], 0.298_806_0, 3e-5),
        ("astigmatism", c[5], -0.207_765_3, 1e-3),
        ("spherical", c[12], 0.009_033_38, 1e-5),
        ("secondary spherical", c[24], 6.612_1e-5, 2e-7),
    ] {
        println!("{name}: {ours:.7}, OpticStudio {theirs:.7}");
        assert!((ours - theirs).abs() < room, "{name}: {ours} {theirs}");
    }
    assert!(c[3].abs() < 1e-10 && c[7].abs() < 1e-10, "symmetry");
}

#[test]
fn rays_stand_on_the_wave() {
    // Malus and Dupin: the rays that leave the eye are square to the fitted wave, to what the sixth
    // order leaves. Directions know nothing of paths.
    let eye = SchematicEye::escudero_navarro(GREEN_NM);
    let wave = on_axis(&eye, 5.0);
    let exit = paraxial(&eye, Meridian::Vertical).exit_pupil;
    let mut worst = 0.0_f64;
    for i in 0..50_i32 {
        let aim = 0.05 * f64::from(i) * DVec2::from_angle(f64::from(i));
        let ray = Ray::new(wave.retina_mm, aim.extend(exit.z_mm) - wave.retina_mm).unwrap();
        let out = trace_out_of(&eye.interfaces, ray).ray().unwrap();
        let z = paraxial(&eye, Meridian::Vertical).entrance_pupil.z_mm;
        let pupil = out.at_depth(z).unwrap().truncate() / wave.pupil_radius_mm;
        if pupil.length() > 0.95 {
            continue;
        }
        let slope: DVec2 = zernike_slopes(pupil)
            .into_iter()
            .zip(wave.coefficients_um)
            .map(|(slope, c)| c * slope)
            .sum();
        // µm per unit pupil; the ray goes against the slope of what is early.
        let expected = -1e-3 / wave.pupil_radius_mm * slope;
        worst = worst.max(out.direction.truncate().distance(expected));
    }
    println!("rays against the slope of their wave: {worst:.1e} rad");
    // The residual, 3e-5 µm, times the slope of an eighth-order term, 30/2.5 mm: 2e-3 arcmin.
    assert!(worst < 5e-7, "{worst}");
}

#[test]
fn spherical_aberration_of_the_published_eyes() {
    // c40 over 6 mm. Living eyes have 0.128 ± 0.074 µm (Salmon & van de Pol 2006, 2560 eyes); Liou &
    // Brennan and Atchison aim there, Navarro has twice as much, eyes of spheres five times.
    let c40 = |eye: &SchematicEye| on_axis(eye, 6.0).coefficients_um[12];
    for (name, eye, low, high) in [
        (
            "Navarro",
            SchematicEye::navarro(0.0, SODIUM_NM),
            0.235,
            0.245,
        ),
        (
            "Escudero-Sanz & Navarro",
            SchematicEye::escudero_navarro(GREEN_NM),
            0.235,
            0.245,
        ),
        ("Le Grand", SchematicEye::le_grand(SODIUM_NM), 0.6, 0.7),
        ("Gullstrand", SchematicEye::gullstrand(SODIUM_NM), 0.6, 0.7),
        (
            "Liou & Brennan",
            SchematicEye::liou_brennan(PHOTOPIC_NM),
            0.09,
            0.11,
        ),
        (
            "Atchison",
            SchematicEye::atchison(0.0, PHOTOPIC_NM),
            0.08,
            0.10,
        ),
    ] {
        let wave = on_axis(&eye, 6.0);
        println!(
            "{name}: c40 {:.4} µm, c60 {:.5}, residual {:.1e}",
            wave.coefficients_um[12], wave.coefficients_um[24], wave.residual_um
        );
        assert!((low..high).contains(&c40(&eye)), "{name}");
        assert!(wave.residual_um < 2e-3);
        // Nothing that turns with the meridian.
        let round = [0, 4, 12, 24].map(|j| wave.coefficients_um[j].powi(2));
        let rest = wave.rms_um(0).powi(2) - round.iter().sum::<f64>();
        assert!(rest.abs() < 1e-12, "{rest}");
    }
    // Fourth power of the radius, less the sixth-order term.
    let eye = SchematicEye::navarro(0.0, SODIUM_NM);
    let ratio = on_axis(&eye, 1.0).coefficients_um[12] / on_axis(&eye, 0.5).coefficients_um[12];
    assert!((ratio - 16.0).abs() < 0.1, "{ratio}");
}

#[test]
fn an_eye_in_focus_on_a_near_object_has_little_defocus() {
    let eye = SchematicEye::navarro(4.0, SODIUM_NM);
    let far_point = -paraxial(&eye, Meridian::Vertical).refraction_at_entrance_pupil_d();
    let object = ObjectPoint {
        vergence_d: far_point,
        ..ObjectPoint::default()
    };
    let wave = trace_wavefront(&eye, 1.0, object).unwrap();
    assert!(
        wave.power_vector().m_d.abs() < 0.03,
        "{:?}",
        wave.power_vector()
    );
}

#[test]
fn off_axis_there_is_oblique_astigmatism_and_coma() {
    let eye = SchematicEye::escudero_navarro(GREEN_NM);
    let at = |azimuth: f64, elevation: f64| {
        let object = ObjectPoint {
            azimuth: azimuth.to_radians(),
            elevation: elevation.to_radians(),
            ..ObjectPoint::default()
        };
        trace_wavefront(&eye, 3.0, object).unwrap()
    };
    for degrees in [10.0, 20.0, 40.0, 60.0] {
        let wave = at(degrees, 0.0);
        println!(
            "{degrees}°: M, J0, J45 = {:.3?}, higher orders {:.3} µm",
            wave.power_vector(),
            wave.rms_um(3)
        );
    }
    let (right, up) = (at(30.0, 0.0), at(0.0, 30.0));
    let numbers = |v: PowerVector| [v.m_d, v.j0_d, v.j45_d];
    let ([m, j0, j45], [m_up, j0_up, _]) =
        (numbers(right.power_vector()), numbers(up.power_vector()));
    // Turning the field by 90° turns the astigmatism.
    assert!((m - m_up).abs() < 1e-9 && (j0 + j0_up).abs() < 1e-9 && j45.abs() < 1e-9);
    // Myopic along the field: the tangential focus lies in front, as in every eye (a few dioptres
    // between the foci at 40°, Escudero-Sanz & Navarro 1999, figure 4).
    assert!(j0 < -0.8);
    let difference = -2.0 * at(40.0, 0.0).power_vector().j0_d;
    assert!((3.0..5.0).contains(&difference), "{difference}");
    // The object on the right falls left on the retina.
    assert!(right.retina_mm.x < -7.0 && right.retina_mm.y.abs() < 1e-9);
    // Coma along the field is odd in it.
    let (plus, minus) = (at(15.0, 0.0), at(-15.0, 0.0));
    let coma = plus.coefficients_um[8];
    assert!(coma.abs() > 0.01 && (coma + minus.coefficients_um[8]).abs() < 1e-9);
    // A diagonal field turns everything with it.
    let elevation = 20_f64.to_radians().sin() / 2_f64.sqrt();
    let azimuth = (elevation / elevation.asin().cos()).asin();
    let diagonal = numbers(at(azimuth.to_degrees(), elevation.asin().to_degrees()).power_vector());
    let straight = numbers(at(20.0, 0.0).power_vector());
    assert!((diagonal[0] - straight[0]).abs() < 1e-6);
    assert!((diagonal[2] - straight[1]).abs() < 1e-6 && diagonal[1].abs() < 1e-6);
}

#[test]
fn nonsense_has_a_typed_answer() {
    let eye = SchematicEye::navarro(0.0, SODIUM_NM);
    for diameter in [0.0, -3.0, f64::NAN, 20.0] {
        let answer = trace_wavefront(&eye, diameter, ObjectPoint::default());
        assert!(matches!(answer, Err(WavefrontError::Pupil(_))));
    }
    for (vergence_d, azimuth) in [(f64::NAN, 0.0), (1e9, 0.0), (0.0, 1.6), (0.0, f64::NAN)] {
        let object = ObjectPoint {
            vergence_d,
            azimuth,
            elevation: 0.0,
        };
        assert_eq!(
            trace_wavefront(&eye, 3.0, object),
            Err(WavefrontError::Object)
        );
    }
    // A lens no wider than 1 mm blocks the pupil's edge.
    let mut narrow = eye;
    narrow.interfaces[3].placed = narrow.interfaces[3].placed.with_aperture(1.0, 1.0);
    let answer = trace_wavefront(&narrow, 6.0, ObjectPoint::default());
    assert_eq!(
        answer,
        Err(WavefrontError::Ray(Traced::Blocked { surface: 3 }))
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn every_legal_object_has_a_finite_answer(
        diameter in 1.0..9.0_f64,
        vergence_d in -20.0..1000.0_f64,
        azimuth in -1.5..1.5_f64,
        elevation in -1.5..1.5_f64,
        refraction in -20.0..20.0_f64,
    ) {
        let object = ObjectPoint { vergence_d, azimuth, elevation };
        for eye in [SchematicEye::navarro(3.0, 555.0), SchematicEye::atchison(refraction, 555.0)] {
            if let Ok(wave) = trace_wavefront(&eye, diameter, object) {
                prop_assert!(wave.coefficients_um.iter().all(|c| c.is_finite()));
                prop_assert!(wave.residual_um.is_finite());
                let v = wave.power_vector();
                prop_assert!([v.m_d, v.j0_d, v.j45_d].iter().all(|d| d.is_finite()));
            }
        }
    }
}
