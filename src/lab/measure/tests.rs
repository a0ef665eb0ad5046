mod light;
mod refraction;
mod surface;

use super::*;
use proptest::prelude::*;
use serde_json::Value;

/// Enough to fill every row.
const LITTLE: Effort = Effort {
    refraction_pairs: 20_000,
    walks: 2_000,
    mtf_pupils_mm: &[1.0, 3.0, 6.0],
};

fn table(table: MeasureTable, eye: &MeasuredEye) -> Value {
    let text = measure_with(table, eye, LITTLE).expect("serializable");
    serde_json::from_str(&text).expect("JSON")
}

fn default_table(of: MeasureTable) -> Value {
    table(of, &MeasuredEye::default())
}

fn rows(table: &Value, list: &str) -> Vec<Value> {
    table[list].as_array().expect(list).clone()
}

/// The number under a key.
fn number(row: &Value, key: &str) -> f64 {
    row[key]
        .as_f64()
        .unwrap_or_else(|| panic!("{key} of {row}"))
}

/// The only row whose keys have these values.
fn find<'a>(rows: &'a [Value], wanted: &[(&str, Value)]) -> &'a Value {
    let fits = |row: &&Value| {
        wanted.iter().all(|(key, value)| match value.as_f64() {
            Some(value) => row[key].as_f64() == Some(value),
            None => row[key] == *value,
        })
    };
    let mut found = rows.iter().filter(fits);
    let row = found.next().unwrap_or_else(|| panic!("no {wanted:?}"));
    assert!(found.next().is_none(), "{wanted:?} is not one row");
    row
}

/// Eyes at the ends of what a patient file allows.
fn eyes() -> Vec<MeasuredEye> {
    let default = MeasuredEye::default();
    vec![
        default.clone(),
        MeasuredEye {
            right_eye: false,
            pupil_diameter_mm: 9.0,
            pupil_nasal_mm: -1.0,
            pupil_superior_mm: 1.0,
            ..default.clone()
        },
        // Steep and deep: folds come into the domain.
        MeasuredEye {
            anterior_radius_mm: 6.0,
            anterior_shape_factor: 0.9,
            limbus_radius_mm: 5.6,
            iris_depth_mm: 4.5,
            pupil_diameter_mm: 1.0,
            ..default.clone()
        },
        // Steep and shallow: the iris plane cuts through the cornea.
        MeasuredEye {
            anterior_radius_mm: 7.0,
            anterior_shape_factor: 1.0,
            posterior_radius_mm: 6.4,
            posterior_shape_factor: 0.9,
            limbus_radius_mm: 6.2,
            iris_depth_mm: 2.5,
            pupil_diameter_mm: 8.0,
            corneal_thickness_mm: 0.9,
            ..default.clone()
        },
        // Flat.
        MeasuredEye {
            age_years: 110.0,
            anterior_radius_mm: 10.0,
            anterior_shape_factor: 0.2,
            posterior_radius_mm: 9.0,
            posterior_shape_factor: 0.2,
            corneal_thickness_mm: 0.3,
            limbus_radius_mm: 5.0,
            iris_depth_mm: 2.5,
            stroma_melanin_fraction: 0.5,
            border_layer_melanin_fraction: 0.5,
            eumelanin_ratio: 1.0,
            stroma_blood_fraction: 0.5,
            lipid_thickness_nm: 0.0,
            glare_pigment: 1.2,
            ..default
        },
    ]
}

const UNITS: [&str; 12] = [
    "_mm",
    "_m",
    "_nm",
    "_d",
    "_deg",
    "_arcmin",
    "_years",
    "_percent",
    "_cpd",
    "_sr",
    "_per_mm",
    "_mm_per_degree",
];
/// Numbers without a unit: shares, ratios, indices, counts.
const PURE: [&str; 45] = [
    "accommodation",
    "all_orders_luminance",
    "all_orders_luminance_standard_error",
    "aqueous_index",
    "anterior_shape_factor",
    "border_layer_albedo",
    "border_layer_melanin_fraction",
    "bytes",
    "cornea_index",
    "diffraction_mtf",
    "ellipse_ratio",
    "entrance_pupil_magnification",
    "eumelanin_ratio",
    "exit_pupil_magnification",
    "film_reflectance",
    "flat_disc_ratio",
    "glare_pigment",
    "hemisphere_energy",
    "lipid_reflectance",
    "many_flux_luminance",
    "mathur_2013_ratio",
    "mean_mtf",
    "melanin_fraction",
    "normalised_hemisphere_energy",
    "pairs",
    "peak_of_bare_plane",
    "peak_of_beam",
    "pigment",
    "polishing_steps",
    "posterior_shape_factor",
    "ratio",
    "rays",
    "reflectance",
    "seed",
    "similarity_error",
    "single_luminance",
    "single_share",
    "single_share_many_flux",
    "single_share_standard_error",
    "stroma_albedo",
    "stroma_blood_fraction",
    "stroma_melanin_fraction",
    "traced_mtf",
    "two_flux_error",
    "visible_share",
];

/// Numbers have their unit in the key, and what is missing has a reason.
fn check(value: &Value, at: &str) {
    match value {
        Value::Object(object) => {
            let none = serde_json::Map::new();
            let reasons = object.get("null_reasons").and_then(Value::as_object);
            let reasons = reasons.unwrap_or(&none);
            for (key, reason) in reasons {
                assert!(object[key].is_null(), "{at}.{key} is there");
                assert!(reason.as_str().is_some_and(|r| r.len() > 4), "{at}.{key}");
            }
            for (key, value) in object {
                assert!(
                    !value.is_null() || reasons.contains_key(key),
                    "{at}.{key} is null without a reason"
                );
                let unit = UNITS.iter().any(|unit| key.ends_with(unit));
                let pure = PURE.contains(&key.as_str())
                    || ["_log", "_best_focus_mtf", "walks"]
                        .iter()
                        .any(|end| key.ends_with(end))
                    || (key.starts_with("share_beyond_") && key.ends_with("_deg"));
                assert!(!value.is_number() || unit || pure, "{at}.{key} has no unit");
                check(value, &format!("{at}.{key}"));
            }
        }
        Value::Array(list) => {
            for (i, value) in list.iter().enumerate() {
                assert!(!value.is_null(), "{at}[{i}]");
                check(value, &format!("{at}[{i}]"));
            }
        }
        _ => {}
    }
}

#[test]
fn every_table_of_every_eye_is_whole() {
    for (i, eye) in eyes().into_iter().enumerate() {
        for of in MeasureTable::ALL {
            if i > 0 && !of.is_of_the_patient() {
                continue;
            }
            let found = table(of, &eye);
            assert_eq!(found["table"], of.name());
            assert_eq!(found["version"], env!("CARGO_PKG_VERSION"));
            assert_eq!(found["meaning"], of.description());
            assert!(!rows(&found, "source").is_empty() && !rows(&found, "notes").is_empty());
            assert_eq!(found.get("patient").is_some(), of.is_of_the_patient());
            assert!(rows(&found, "rows").len() >= 13, "{}", of.name());
            check(&found, of.name());
        }
    }
}

#[test]
fn the_check_of_a_table_can_fail() {
    let refused = |value: Value| std::panic::catch_unwind(|| check(&value, "x")).is_err();
    assert!(!refused(serde_json::json!({"power_d": 60.0})));
    assert!(refused(serde_json::json!({"power": 60.0})));
    assert!(refused(serde_json::json!({"power_d": null})));
    let reasons = serde_json::json!({"power_d": "there is none"});
    assert!(!refused(
        serde_json::json!({"power_d": null, "null_reasons": reasons})
    ));
    assert!(refused(
        serde_json::json!({"power_d": 1.0, "null_reasons": reasons})
    ));
}

#[test]
fn the_same_table_is_the_same_bytes() {
    let eye = MeasuredEye::default();
    let effort = Effort {
        refraction_pairs: 500,
        walks: 100,
        mtf_pupils_mm: &[3.0],
    };
    for of in MeasureTable::ALL {
        let twice = [(); 2].map(|()| measure_with(of, &eye, effort).expect("serializable"));
        assert_eq!(twice[0], twice[1], "{}", of.name());
        assert!(!twice[0].ends_with('\n'));
    }
}

#[test]
fn names_are_those_of_the_command_line() {
    let names = MeasureTable::ALL.map(MeasureTable::name);
    for (i, name) in names.iter().enumerate() {
        assert!(name.bytes().all(|b| b.is_ascii_lowercase() || b == b'-'));
        assert!(!names[..i].contains(name));
    }
}

#[test]
fn what_is_not_finite_is_null_with_a_reason() {
    let mut reasons = NullReasons::new();
    for value in [None, Some(f64::NAN), Some(f64::INFINITY)] {
        assert_eq!(known(&mut reasons, "x", value, "why"), None);
        assert_eq!(reasons.remove("x").as_deref(), Some("why"));
    }
    let zero = known(&mut reasons, "x", Some(-0.0), "why");
    assert!(zero.is_some_and(|zero| zero.is_sign_positive()) && reasons.is_empty());
}

/// Tables of a patient, with next to no work.
fn quick_tables(eye: &MeasuredEye) -> Vec<Value> {
    let effort = Effort {
        refraction_pairs: 50,
        walks: 2,
        mtf_pupils_mm: &[],
    };
    let own = MeasureTable::ALL
        .into_iter()
        .filter(|of| of.is_of_the_patient());
    own.map(|of| {
        let text = measure_with(of, eye, effort).expect("serializable");
        serde_json::from_str(&text).expect("JSON")
    })
    .collect()
}

proptest! {
    // Each case builds two refraction functions, 40 ms.
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn tables_of_any_patient_are_whole(
        right_eye in any::<bool>(),
        ages in (1.0..110.0_f64, 0.0..200.0_f64, 0.0..1.2_f64),
        anterior in (6.0..10.0_f64, 0.2..1.5_f64),
        posterior in (5.0..9.0_f64, 0.2..1.5_f64, 0.3..0.9_f64),
        globe in (5.0..6.5_f64, 2.5..4.5_f64),
        pupil in (1.0..9.0_f64, -1.0..1.0_f64, -1.0..1.0_f64),
        pigment in (0.0..0.5_f64, 0.0..0.5_f64, 0.0..1.0_f64),
    ) {
        let eye = MeasuredEye {
            right_eye,
            age_years: ages.0,
            lipid_thickness_nm: ages.1,
            glare_pigment: ages.2,
            anterior_radius_mm: anterior.0,
            // The surface reaches the limbus, as the patient file asks.
            anterior_shape_factor: anterior.1.min((anterior.0 / (1.06 * globe.0)).powi(2)),
            posterior_radius_mm: posterior.0,
            posterior_shape_factor: posterior.1.min((posterior.0 / (1.02 * globe.0)).powi(2)),
            corneal_thickness_mm: posterior.2,
            limbus_radius_mm: globe.0,
            iris_depth_mm: globe.1,
            pupil_diameter_mm: pupil.0,
            pupil_nasal_mm: pupil.1,
            pupil_superior_mm: pupil.2,
            stroma_melanin_fraction: pigment.0,
            border_layer_melanin_fraction: pigment.1,
            eumelanin_ratio: pigment.2,
            stroma_blood_fraction: 0.5 - pigment.0,
            ..MeasuredEye::default()
        };
        for table in quick_tables(&eye) {
            check(&table, "table");
        }
    }

    #[test]
    fn nonsense_does_not_panic(
        a in prop::num::f64::ANY, b in prop::num::f64::ANY, c in prop::num::f64::ANY,
        d in prop::num::f64::ANY, e in prop::num::f64::ANY,
    ) {
        let eye = MeasuredEye {
            age_years: a,
            anterior_radius_mm: a,
            anterior_shape_factor: b,
            posterior_radius_mm: c,
            limbus_radius_mm: d,
            iris_depth_mm: e,
            pupil_diameter_mm: b,
            stroma_melanin_fraction: c,
            lipid_thickness_nm: d,
            ..MeasuredEye::default()
        };
        prop_assert_eq!(quick_tables(&eye).len(), 6);
    }
}
