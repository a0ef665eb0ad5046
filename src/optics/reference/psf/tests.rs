use super::*;
use crate::optics::reference::wavefront::{ObjectPoint, trace_wavefront};
use crate::optics::reference::zernike::zernike_rms;
use crate::optics::schematic_eye::{GREEN_NM, SchematicEye};
use proptest::prelude::*;

const NONE: [f64; ZERNIKE_COUNT] = [0.0; ZERNIKE_COUNT];

fn pupil(coefficients_um: &[f64; ZERNIKE_COUNT], diameter_mm: f64) -> PupilFunction<'_> {
    PupilFunction {
        coefficients_um,
        diameter_mm,
        wavelength_nm: 555.0,
        stiles_crawford: 0.0,
    }
}

fn spread(size: usize, coefficients: &[f64; ZERNIKE_COUNT], diameter: f64) -> (PsfGrid, Psf) {
    let grid = PsfGrid::for_pupil(size, diameter, 555.0).unwrap();
    let psf = grid.psf(&pupil(coefficients, diameter)).unwrap();
    (grid, psf)
}

/// Bessel's J1 by its series, for |x| < 12.
fn j1(x: f64) -> f64 {
    let mut term = 0.5 * x;
    let mut sum = term;
    for k in 1..60 {
        let k = f64::from(k);
        term *= -0.25 * x * x / (k * (k + 1.0));
        sum += term;
    }
    sum
}

#[test]
fn without_aberrations_it_is_airy_s_disc() {
    for size in [128, 256, 512] {
        let (grid, psf) = spread(size, &NONE, 3.0);
        let energy: f64 = psf.values.iter().sum();
        assert!((energy - 1.0).abs() < 1e-12);
        assert!((psf.strehl - 1.0).abs() < 1e-12);
        let half = size / 2;
        let peak = psf.values[half * size + half];
        let mut airy_error = 0.0_f64;
        for i in 1..12 {
            // Four pixels to λ/D.
            let x = PI * 0.25 * i as f64;
            let expected = (2.0 * j1(x) / x).powi(2);
            let got = psf.values[half * size + half + i] / peak;
            airy_error = airy_error.max((got - expected).abs());
        }
        // Energy in the first dark ring: 83.8 %.
        let mtf = grid.mtf(&psf);
        let mut mtf_error = 0.0_f64;
        for i in 0..half {
            let cpd = i as f64 * mtf.cycles_per_degree;
            let got = mtf.values[half * size + half + i.min(half - 1)];
            mtf_error = mtf_error.max((got - diffraction_mtf(cpd, 3.0, 555.0)).abs());
        }
        println!(
            "grid {size}: Airy disc off by {airy_error:.1e} of its peak, MTF by {mtf_error:.1e}"
        );
        // The edge is known to an eighth of a pixel of the pupil, size/4 across.
        assert!(airy_error < 0.1 / size as f64 && mtf_error < 0.6 / size as f64);
    }
}

#[test]
fn the_cut_off_and_the_scale_are_right() {
    // 3 mm and 555 nm: 94.3 cycles/degree.
    assert_eq!(diffraction_mtf(0.0, 3.0, 555.0), 1.0);
    assert!(diffraction_mtf(94.2, 3.0, 555.0) > 0.0);
    assert_eq!(diffraction_mtf(94.5, 3.0, 555.0), 0.0);
    assert_eq!(diffraction_mtf(f64::NAN, 3.0, 555.0), 0.0);
    // A known point: û = 1/2 gives 0.39100.
    assert!(
        (diffraction_mtf(0.5 * 3.0 / 555e-6 * PI / 180.0, 3.0, 555.0) - 0.391_002).abs() < 1e-6
    );
    let grid = PsfGrid::for_pupil(256, 3.0, 555.0).unwrap();
    // λ/4D.
    assert!((grid.arcmin_per_pixel - 0.25 * 555e-6 / 3.0 * 3437.7467707849).abs() < 1e-9);
}

#[test]
fn strehl_s_ratio_is_marechal_s() {
    for (j, sigma) in [(4, 0.01), (7, 0.015), (12, 0.02), (3, 0.02), (22, 0.01)] {
        let mut c = NONE;
        c[j] = sigma;
        let (_, psf) = spread(256, &c, 4.0);
        let phase = TAU * sigma / 0.555;
        let expected = (-phase * phase).exp();
        // Next term: the phase's fourth power; its third moment for c40.
        assert!(
            (psf.strehl - expected).abs() < phase.powi(3),
            "{j} {} {expected}",
            psf.strehl
        );
    }
}

#[test]
fn a_sloping_wave_moves_the_image_where_it_says() {
    // 2 arcmin along +x: W = θ x, in µm over a radius of 1.5 mm.
    let mut c = NONE;
    let grid = PsfGrid::for_pupil(256, 3.0, 555.0).unwrap();
    let pixels = 12.0;
    let theta = pixels * grid.arcmin_per_pixel * ARCMIN;
    // Z1,1 = 2x.
    c[2] = 0.5 * theta * 1.5e3;
    let psf = grid.psf(&pupil(&c, 3.0)).unwrap();
    let top = psf
        .values
        .iter()
        .enumerate()
        .max_by(|a, b| a.1.total_cmp(b.1))
        .unwrap()
        .0;
    assert_eq!((top / 256, top % 256), (128, 140));
    c[2] = 0.0;
    c[1] = -0.5 * theta * 1.5e3;
    let psf = grid.psf(&pupil(&c, 3.0)).unwrap();
    assert!(psf.values[116 * 256 + 128] > 0.9 * psf.values.iter().copied().fold(0.0, f64::max));
}

#[test]
fn large_defocus_is_the_geometric_disc() {
    // 3 D through 4 mm: a disc of 41 arcmin.
    let mut c = NONE;
    c[4] = crate::optics::reference::zernike::zernike_from_refraction(
        crate::optics::defocus::PowerVector::from_sphere_cylinder(-3.0, 0.0, 0.0),
        2.0,
    )[1];
    let (_, psf) = spread(512, &c, 4.0);
    let radius = 0.5 * crate::optics::defocus::defocus_blur_angle(4e-3, 3.0, 0.0, 0.0) / ARCMIN;
    // Energy by area inside, but for the rings of diffraction at an edge 11 wavelengths out.
    for share in [0.3, 0.6, 0.8] {
        let inside = psf.encircled(share * radius);
        assert!((inside - share * share).abs() < 0.03, "{share} {inside}");
    }
    assert!(psf.encircled(1.1 * radius) > 0.97);
}

#[test]
fn the_mtf_of_an_eye_is_worse_than_diffraction_s_and_moves_with_the_wavefront() {
    let eye = SchematicEye::escudero_navarro(GREEN_NM);
    for diameter in [3.0, 6.0] {
        let wave = trace_wavefront(&eye, diameter, ObjectPoint::default()).unwrap();
        let (grid, psf) = spread(512, &wave.coefficients_um, diameter);
        let mtf = grid.mtf(&psf);
        let at = [5.0, 10.0, 20.0, 40.0].map(|cpd| mtf.radial(cpd));
        println!(
            "Navarro {diameter} mm: Strehl {:.3}, RMS {:.3} µm, MTF at 5, 10, 20, 40 c/deg {at:.3?}",
            psf.strehl,
            zernike_rms(&wave.coefficients_um, 1)
        );
        for (cpd, value) in [5.0, 10.0, 20.0, 40.0].into_iter().zip(at) {
            assert!(value < diffraction_mtf(cpd, diameter, 555.0) + 1e-3);
        }
        // A round eye has a round MTF.
        assert!((mtf.at(15.0, 0.0) - mtf.at(0.0, 15.0)).abs() < 1e-9);
    }
}

#[test]
fn colours_add_up() {
    let grid = PsfGrid::new(256, 0.15).unwrap();
    let parts = [450.0, 550.0, 650.0].map(|wavelength_nm| {
        (
            PupilFunction {
                wavelength_nm,
                ..pupil(&NONE, 3.0)
            },
            2.0,
        )
    });
    let white = grid.polychromatic_psf(&parts).unwrap();
    assert!((white.values.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    assert!((white.strehl - 1.0).abs() < 1e-12);
    // The blue image is the sharper one.
    let single = |i: usize| grid.psf(&parts[i].0).unwrap();
    assert!(single(0).encircled(0.6) > single(2).encircled(0.6));
    assert!(grid.polychromatic_psf(&[]).is_err());
}

#[test]
fn the_stiles_crawford_effect_narrows_the_pupil() {
    let grid = PsfGrid::for_pupil(256, 7.0, 555.0).unwrap();
    let mut c = NONE;
    c[4] = 0.4;
    let plain = grid.psf(&pupil(&c, 7.0)).unwrap();
    let apodised = grid
        .psf(&PupilFunction {
            stiles_crawford: STILES_CRAWFORD,
            ..pupil(&c, 7.0)
        })
        .unwrap();
    assert!((apodised.values.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    assert!(apodised.strehl > plain.strehl);
}

#[test]
fn grids_that_cannot_hold_the_image_say_so() {
    assert!(matches!(PsfGrid::new(100, 0.1), Err(PsfError::Size(100))));
    assert!(PsfGrid::new(128, f64::NAN).is_err());
    let grid = PsfGrid::new(256, 0.4).unwrap();
    assert!(matches!(
        grid.psf(&pupil(&NONE, 6.0)),
        Err(PsfError::Coarse(_))
    ));
    let grid = PsfGrid::new(64, 0.01).unwrap();
    assert!(matches!(
        grid.psf(&pupil(&NONE, 2.0)),
        Err(PsfError::Fine(_))
    ));
    let mut c = NONE;
    c[4] = 20.0;
    let grid = PsfGrid::for_pupil(256, 4.0, 555.0).unwrap();
    assert!(matches!(grid.psf(&pupil(&c, 4.0)), Err(PsfError::Wide(_))));
    c[4] = f64::NAN;
    assert!(matches!(
        grid.psf(&pupil(&c, 4.0)),
        Err(PsfError::OutOfRange { .. })
    ));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]
    #[test]
    fn energy_is_one_and_modulation_below(
        c in prop::array::uniform32(-0.3..0.3_f64),
        diameter in 1.0..9.0_f64,
        stiles_crawford in 0.0..0.1_f64,
    ) {
        let coefficients: [f64; ZERNIKE_COUNT] = core::array::from_fn(|j| c[j]);
        let grid = PsfGrid::for_pupil(128, diameter, 555.0).unwrap();
        let pupil = PupilFunction { stiles_crawford, ..pupil(&coefficients, diameter) };
        if let Ok(psf) = grid.psf(&pupil) {
            prop_assert!((psf.values.iter().sum::<f64>() - 1.0).abs() < 1e-10);
            prop_assert!(psf.strehl > 0.0 && psf.strehl < 1.0 + 1e-9);
            let mtf = grid.mtf(&psf);
            prop_assert!(mtf.values.iter().all(|m| (0.0..1.0 + 1e-9).contains(m)));
        }
    }
}
