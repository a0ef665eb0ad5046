//! Patient files as users write them, sound and not.

use super::*;

#[test]
fn every_preset_is_sound() {
    for preset in crate::patients::PRESETS {
        let patient = load_patient(preset.name).expect(preset.name);
        assert!(
            !patient.description.is_empty(),
            "{} has no description",
            preset.name
        );
    }
}

#[test]
fn an_empty_patient_is_the_default_one() {
    assert_eq!(
        parse_patient("()", "x").expect("sound"),
        PatientFile::default()
    );
}

#[test]
fn errors_name_file_field_value_and_range() {
    let said = |text: &str| parse_patient(text, "p.ron").expect_err(text).to_string();
    let error = said("(age_years: 300.0)");
    for part in ["p.ron", "age_years", "300", "1 to 110"] {
        assert!(error.contains(part), "{error}");
    }
    assert!(parse_patient("\u{feff}(age_years: 40.0)", "p.ron").is_ok());
    assert!(said("(name: \"\\u{1b}[31mAnn\")").contains("control"));
    assert!(said("(sphere_d: NaN)").contains("NaN"));
    assert!(said("(pupil: Fixed(0.5))").contains("1 to 9"));
    let error = said("(eye_color: Blue)");
    assert!(
        error.contains("eye_color") && error.contains("iris_color"),
        "{error}"
    );
    assert!(said("(iris_color: Purple)").contains("Brown"));
    assert_eq!(
        said("(age_years: \"old\")"),
        "p.ron:1:13: age_years = \"old\" is not allowed; it must be a number, 1 to 110"
    );
    assert!(said("(cornea_p: 1.5, cornea_radius_mm: 6.0)").contains("limbus"));
    // A thicker cornea would do, or none would.
    for (text, blamed) in [
        (
            "(cornea_radius_mm: 6.8, cornea_posterior_radius_mm: 8.2)",
            "cornea_thickness_mm = 0.55",
        ),
        (
            "(cornea_radius_mm: 6.6, cornea_posterior_radius_mm: 9.0)",
            "cornea_posterior_radius_mm = 9 ",
        ),
    ] {
        let crossing = said(text);
        assert!(
            crossing.contains(blamed) && crossing.contains("cross before the limbus"),
            "{crossing}"
        );
    }
}

#[test]
fn one_eye_may_have_what_the_other_has_not() {
    let text = "(sphere_d: -1.0, left: (sphere_d: -4.0, iris_color: Blue))";
    let file = parse_patient(text, "p.ron").expect("sound");
    let [right, left] = Laterality::BOTH.map(|eye| file.of_eye(eye));
    assert_eq!((right.sphere_d, left.sphere_d), (-1.0, -4.0));
    assert_ne!(right.iris_color, left.iris_color);
    let said = |text: &str| parse_patient(text, "p.ron").expect_err(text).to_string();
    let error = said("(left: (sphere_d: -40.0))");
    for part in ["p.ron", "left.sphere_d", "-40", "-20 to 20"] {
        assert!(error.contains(part), "{error}");
    }
    assert!(!said("(sphere_d: -40.0)").contains("right"));
    // What both share is nobody's alone, however else the eyes differ.
    let error = said("(age_years: 300.0, left: (sphere_d: -4.0))");
    assert!(
        !error.contains("right") && !error.contains("left"),
        "{error}"
    );
    let error = said("(right: (age_years: 4.0))");
    assert!(
        error.contains("age_years") && error.contains("outside of right"),
        "{error}"
    );
}

#[test]
fn a_value_of_another_kind_is_told_what_may_stand_there() {
    for (text, parts) in [
        (
            "(left: (redness: yes))",
            &["left.redness = yes", "a number, 0 to 1"][..],
        ),
        (
            "(pupil: 4.0)",
            &["pupil = 4.0", "Auto or Fixed(mm), 1 to 9"],
        ),
        ("(pupil: Fixed(wide))", &["pupil.Fixed = wide", "1 to 9"]),
        ("(eye: Right)", &["eye = Right", "OD or OS"]),
        ("(seed: -1)", &["seed = -1", "whole number"]),
        ("(seed: 1.5)", &["seed = 1.5", "whole number"]),
        ("(name: Ann)", &["name = Ann", "quotation marks"]),
        (
            "(angle_alpha_deg: 5.0)",
            &["angle_alpha_deg = 5.0", "each -15 to 15"],
        ),
        (
            "(angle_alpha_deg: [5.0, 1.0])",
            &["angle_alpha_deg", "round brackets"],
        ),
        (
            "(angle_alpha_deg: (5.0, 1.0, 2.0))",
            &["angle_alpha_deg", "two numbers"],
        ),
        (
            "(angle_alpha_deg: (5.0, 20.0))",
            &["angle_alpha_deg = (5, 20)", "each -15 to 15"],
        ),
        (
            "(glaucoma: Bad)",
            &["glaucoma = Bad", "it must be `Early`", "MeanDeviation"],
        ),
        (
            "(glaucoma: MeanDeviation(-3, 1))",
            &["glaucoma.MeanDeviation = -3, 1 is"],
        ),
        ("(pupil: Fixed)", &["pupil.Fixed has no value", "1 to 9"]),
        (
            "(shpere_d: 1)",
            &["\"shpere_d\" of a patient", "mean sphere_d?"],
        ),
        (
            "(left: (sphere_d: None))",
            &["left.sphere_d = None", "-20 to 20"],
        ),
        ("(sphere_d: 1,5)", &["p.ron:1:13", "decimal point"]),
        ("", &["it is empty"]),
        (
            "(glaucoma: MeanDeviation(x))",
            &["glaucoma.MeanDeviation = x", "-30 to 0"],
        ),
        (
            "(glaucoma: MeanDeviation(-40))",
            &["glaucoma = MeanDeviation(-40", "-30 to 0"],
        ),
        (
            "(cataract: (log_s: 2.6))",
            &["cataract.log_s = 2.6", "0.5 to 2.5"],
        ),
        (
            "(right: (cataract: (nuclear: 7)))",
            &["right.cataract.nuclear = 7", "0 to 6.9"],
        ),
        (
            "(cataract: (nuclear: much))",
            &["cataract.nuclear = much", "0 to 6.9"],
        ),
        (
            "(cataract: (center: 1.0))",
            &["fields of cataract are nuclear"],
        ),
        ("(cataract: 3)", &["cataract = 3", "nuclear: 0 to 6.9"]),
        ("(ptosis: ())", &["mrd1_mm of ptosis is missing"]),
        ("(left: 3)", &["left = 3", "(sphere_d: -2.0)"]),
        (
            "(left: (age_years: 4.0))",
            &["age_years belongs to the person", "outside of left"],
        ),
        (
            "(left: (colour: 4.0))",
            &["\"colour\"", "fields of one eye"],
        ),
        (
            "(age_years: 3.0, age_years: 4.0)",
            &["age_years of a patient is given twice"],
        ),
        ("(age_years: 3.0", &["bracket"]),
        ("[1, 2]", &["not a patient file"]),
    ] {
        let error = parse_patient(text, "p.ron").expect_err(text).to_string();
        for part in parts.iter().chain([&"p.ron"]) {
            assert!(error.contains(part), "{text}: {error} lacks {part}");
        }
        for parser in ["Laterality", "PatientFile", "EyeFile", "Expected", "f64"] {
            assert!(!error.contains(parser), "{text}: {error}");
        }
    }
}

#[test]
fn one_eye_may_lack_what_both_have() {
    let file = parse_patient(
        "(cataract: (nuclear: 3.0), eumelanin_ratio: 0.2, right: (cataract: None, eumelanin_ratio: None))",
        "p.ron",
    )
    .expect("sound");
    let [right, left] = Laterality::BOTH.map(|eye| file.of_eye(eye));
    assert_eq!((right.cataract, right.eumelanin_ratio), (None, None));
    assert!(left.cataract.is_some() && left.eumelanin_ratio.is_some());
    let text = ron::ser::to_string(&file).expect("RON");
    assert_eq!(parse_patient(&text, "again").expect("sound"), file);
}

#[test]
fn unknown_names_list_the_known_ones() {
    let error = load_patient("nobody").expect_err("unknown").to_string();
    assert!(
        error.contains("healthy-brown") && error.contains("glaucoma-moderate"),
        "{error}"
    );
}

#[test]
fn a_file_survives_being_written_and_read() {
    let patient = load_patient("glaucoma-moderate").expect("preset");
    let text = ron::ser::to_string(&patient).expect("RON");
    assert_eq!(parse_patient(&text, "again").expect("sound"), patient);
}
