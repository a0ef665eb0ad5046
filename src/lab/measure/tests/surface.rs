//! Tissue and tear film against published values and their own scatter.

use super::*;

#[test]
fn tissue_has_its_published_coefficients() {
    let found = default_table(MeasureTable::Tissue);
    // François, equations 10 to 14 at 500 nm, by a separate program to six digits.
    let at = rows(&found, "coefficients");
    let row = find(&at, &[("wavelength_nm", 500.0.into())]);
    for (key, expected) in [
        ("eumelanin_absorption_per_mm", 67.9163),
        ("pheomelanin_absorption_per_mm", 43.8824),
        ("pheomelanin_absorption_dilute_per_mm", 4.38824),
        ("baseline_absorption_per_mm", 0.0702217),
        ("mie_scattering_per_mm", 3.75599),
        ("rayleigh_scattering_per_mm", 3.52),
        // By hand: 2.302585 (0.8 · 20932.8 + 0.2 · 20862.0) 150/64500 = 112.02 cm⁻¹, and (1 − e^−µd)/d at 0.02 mm.
        ("blood_absorption_per_mm", 10.03553),
    ] {
        assert!((number(row, key) / expected - 1.0).abs() < 1e-5, "{key}");
    }
    // A blue iris as it is seen, and more melanin is darker.
    let irises = rows(&found, "irises");
    let blue = find(&irises, &[("iris", "blue".into())]);
    for (channel, expected) in [0.120, 0.132, 0.149].into_iter().enumerate() {
        let got = blue["seen_linear_srgb"][channel]
            .as_f64()
            .expect("a number");
        assert!((got - expected).abs() < 0.01, "{blue}");
    }
    let colours = rows(&found, "rows");
    for pair in colours.windows(2) {
        if pair[0]["eumelanin_ratio"] == pair[1]["eumelanin_ratio"] {
            for channel in 0..3 {
                let at = |row: &Value| row["linear_srgb"][channel].as_f64().expect("a number");
                assert!(at(&pair[1]) < at(&pair[0]), "{pair:?}");
            }
        }
    }
    let scattering = rows(&found, "scattering");
    assert_eq!(scattering.len(), 5);
    let (mut last, mut pale) = (0.0, Vec::new());
    for row in &scattering {
        let [share, error, exact] = [
            "single_share",
            "single_share_standard_error",
            "single_share_many_flux",
        ]
        .map(|key| number(row, key));
        // Five seeded draws within four standard errors of what has no noise, and not all at 0.
        assert!(
            (share - exact).abs() < 4.0 * error && share != exact,
            "{row}"
        );
        assert!(error > 1e-3 && error < 3e-2, "{row}");
        // Blood, of which green irises have least, takes what is scattered often first: of the pale ones either may lead.
        match row["iris"].as_str() {
            Some("blue" | "green") => {
                pale.push(share);
                last = pale.iter().copied().fold(last, f64::max);
            }
            Some("hazel" | "brown") => {
                assert!(pale.len() == 2 && share > last, "{row}");
                last = share;
            }
            _ => {}
        }
    }
}

#[test]
fn standard_errors_are_the_scatter_of_repeated_runs() {
    let runs: Vec<_> = (0..40)
        .map(|seed| tissue::scattering_row("green", &IrisPigment::GREEN, 500, seed))
        .collect();
    let n = runs.len() as f64;
    let mean = runs.iter().map(|run| run.single_share).sum::<f64>() / n;
    let scatter = runs
        .iter()
        .map(|run| (run.single_share - mean).powi(2))
        .sum::<f64>()
        / (n - 1.0);
    let stated = runs
        .iter()
        .map(|run| run.single_share_standard_error.powi(2))
        .sum::<f64>()
        / n;
    // A variance from 40 runs is known to √(2/39) = 23 %; three of those.
    assert!((scatter / stated - 1.0).abs() < 0.69, "{scatter} {stated}");
}

#[test]
fn the_tear_film_reflects_what_airys_sum_says() {
    let found = default_table(MeasureTable::TearFilm);
    let rows = rows(&found, "rows");
    // REFERENCE: percent at 450, 550, 650 nm, perpendicular, last digit as printed.
    for (thickness, percent) in [
        (0.0, [2.08, 2.08, 2.08]),
        (80.0, [5.83, 5.68, 5.23]),
        (120.0, [3.54, 5.14, 5.78]),
    ] {
        let wanted = [
            ("of", "grid".into()),
            ("lipid_thickness_nm", Value::from(thickness)),
            ("incidence_deg", 0.0.into()),
        ];
        let spectrum = find(&rows, &wanted)["spectrum"].as_array().expect("a list");
        for (nm, expected) in [450.0, 550.0, 650.0].into_iter().zip(percent) {
            let row = find(spectrum, &[("wavelength_nm", nm.into())]);
            let got = 100.0 * number(row, "lipid_reflectance");
            assert!(
                (got - expected).abs() < 0.006,
                "{thickness} nm at {nm} nm: {got}"
            );
            // The epithelium adds 0.05 %, dispersion takes or gives as much.
            let whole = 100.0 * number(row, "film_reflectance");
            assert!((whole - got).abs() < 0.2, "{row}");
        }
    }
    for row in &rows {
        for channel in 0..3 {
            let at = |key: &str| row[key][channel].as_f64().expect("a number");
            // The error of the shader's form, as in optics::tear_film up to 200 nm.
            assert!(
                (at("linear_srgb") - at("shader_linear_srgb")).abs() < 3.6e-5,
                "{row}"
            );
        }
    }
    let own = rows.iter().filter(|row| row["of"] == "patient");
    assert!(own.clone().count() == 4 && own.clone().all(|row| row["lipid_thickness_nm"] == 55.0));
}
