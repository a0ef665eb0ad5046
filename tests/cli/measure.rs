//! The tables of `measure`: whole JSON on standard output or in a file, the library's numbers, and one
//! sentence for what cannot be.

use super::{Files, misused, program, refused, run, said, text};
use ocularium::lab::measure::{MeasureTable, MeasuredEye, measure};
use ocularium::optics::pupil::entrance_pupil_magnification;
use ocularium::optics::reference::paraxial::{Meridian, paraxial};
use ocularium::optics::schematic_eye::{SODIUM_NM, SchematicEye};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Stdio;

fn parsed(text: &str) -> Value {
    serde_json::from_str(text).expect("JSON")
}

fn rows(table: &Value) -> &[Value] {
    table["rows"].as_array().expect("rows")
}

/// Every `null` has a reason, and nothing is empty.
fn check(value: &Value, at: &str) {
    match value {
        Value::Object(object) => {
            for (key, value) in object {
                assert!(
                    !value.is_null() || object["null_reasons"][key].is_string(),
                    "{at}.{key} is null without a reason"
                );
                check(value, &format!("{at}.{key}"));
            }
        }
        Value::Array(list) => {
            assert!(!list.is_empty(), "{at} is empty");
            for value in list {
                check(value, at);
            }
        }
        _ => {}
    }
}

#[test]
fn every_table_is_json_and_says_what_it_is() {
    assert!(said(&["--help"]).contains("measure"));
    let help = said(&["measure", "--help"]);
    for table in MeasureTable::ALL {
        assert!(help.contains(table.name()), "no {} in {help}", table.name());
        // The help is wrapped; its first words stay together.
        let first: Vec<&str> = table.description().split(' ').take(2).collect();
        assert!(help.contains(&first.join(" ")), "no {first:?} in {help}");

        let found = parsed(&said(&["measure", table.name()]));
        assert_eq!(found["table"], table.name());
        assert_eq!(found["version"], env!("CARGO_PKG_VERSION"));
        assert_eq!(found.get("patient").is_some(), table.is_of_the_patient());
        check(&found, table.name());
        assert!(rows(&found).len() >= 13, "{}", table.name());
    }
    for word in ["--out", "--patient", "JSON", "blur-disc and mtf"] {
        assert!(help.contains(word), "no {word} in {help}");
    }
}

#[test]
fn the_numbers_are_the_librarys_and_the_published_ones() {
    let eyes = said(&["measure", "eyes"]);
    // Tables of no patient are those of the library, byte for byte, and a line feed.
    let library = measure(MeasureTable::Eyes, &MeasuredEye::default()).expect("JSON");
    assert_eq!(eyes, library + "\n");
    let eyes = parsed(&eyes);
    let power = |name: &str| {
        let mut relaxed = rows(&eyes).iter().filter(|row| row["state"] == "relaxed");
        let row = relaxed.find(|row| row["eye"] == name).expect(name);
        row["power_d"].as_f64().expect("a number")
    };
    let navarro = paraxial(&SchematicEye::navarro(0.0, SODIUM_NM), Meridian::Vertical);
    // A parser may lose the last bit.
    assert!((power("Navarro 1985") - navarro.power_d).abs() < 1e-13);
    // As printed: Navarro 1985, abstract; Atchison & Smith 2000, appendix 3.
    assert!((power("Navarro 1985") - 60.416).abs() < 6e-4);
    assert!((power("Le Grand") - 59.940).abs() < 6e-4);
    assert!((power("Gullstrand No. 1") - 58.636).abs() < 6e-4);
}

#[test]
fn a_patient_acts_where_the_help_says_so() {
    let files = Files::new();
    let patient = files.write(
        "ann.ron",
        b"(name: \"Ann\", eye: OS, age_years: 61, iris_color: Blue, pupil: Fixed(6.0), \
           pupil_decentration_mm: (0.3, 0.1), cornea_radius_mm: 7.6, iris_depth_mm: 3.4, \
           lipid_thickness_nm: 90)",
    );
    let of = |table: &str| parsed(&said(&["measure", table, "--patient", &patient]));
    let own = |table: &Value, key: &str, list: &str| -> Value {
        let list = table[list].as_array().expect("a list");
        let row = list.iter().find(|row| row[key] == "patient");
        row.expect("the patient's own").clone()
    };

    let pupil = of("pupil-ratio");
    // The file says how wide the pupil looks; the hole in the iris is as much smaller as the cornea
    // magnifies near its axis (rays at 3 mm from it give 1.7 % less).
    let magnification = entrance_pupil_magnification(7.6, 6.4, 0.55, 1.376, 1.336, 3.4);
    let ann = MeasuredEye {
        name: "Ann".into(),
        right_eye: false,
        age_years: 61.0,
        anterior_radius_mm: 7.6,
        iris_depth_mm: 3.4,
        pupil_diameter_mm: 6.0 / magnification,
        pupil_nasal_mm: 0.3,
        pupil_superior_mm: 0.1,
        stroma_melanin_fraction: 0.0004,
        border_layer_melanin_fraction: 0.035,
        eumelanin_ratio: 0.1,
        stroma_blood_fraction: 0.02,
        glare_pigment: 1.2,
        lipid_thickness_nm: 90.0,
        ..MeasuredEye::default()
    };
    let library = measure(MeasureTable::PupilRatio, &ann).expect("JSON");
    assert_eq!(pupil, parsed(&library));
    let front = rows(&pupil).iter().find(|row| row["angle_deg"] == 0.0);
    let width = front.expect("straight ahead")["apparent_width_mm"].as_f64();
    assert!(
        width.is_some_and(|width| (5.85..6.05).contains(&width)),
        "{width:?}"
    );
    // Without a pupil in the file it is 4 mm wide.
    let auto = parsed(&said(&["measure", "pupil-ratio"]));
    assert_eq!(auto["patient"]["pupil_diameter_mm"], 4.0);

    let glare = own(&of("glare"), "of", "integrals");
    assert_eq!(
        (&glare["age_years"], &glare["pigment"]),
        (&61.0.into(), &1.2.into())
    );
    let iris = own(&of("tissue"), "iris", "irises");
    assert_eq!(iris["stroma_melanin_fraction"], 0.0004);
    let film = own(&of("tear-film"), "of", "rows");
    assert_eq!(film["lipid_thickness_nm"], 90.0);
    // A cataract scatters more than a clear eye as old, as its straylight says.
    let clouded = files.write(
        "eve.ron",
        b"(age_years: 61, cataract: (cortical: 3.0, log_s: Some(2.0)))",
    );
    let glare_of = |patient: &str| {
        let table = parsed(&said(&["measure", "glare", "--patient", patient]));
        let rows = table["rows"].as_array().expect("rows").clone();
        let seven = |row: &&Value| row["of"] == "patient" && row["angle_deg"] == 7.0;
        let row = rows.iter().find(seven).expect("at 7°").clone();
        ["media_spread_per_sr", "measured_straylight_log"].map(|key| row[key].as_f64())
    };
    let [added, log] = glare_of(&clouded);
    assert!(added > Some(0.1), "{added:?}");
    assert!(log.is_some_and(|log| (log - 2.0).abs() < 0.02), "{log:?}");
    assert_eq!(glare_of(&patient)[0], Some(0.0));
    // The tables of published eyes stay what they are, and say so.
    let alone = said(&["measure", "blur-disc"]);
    let other = run(&["measure", "blur-disc", "--patient", &patient]);
    assert!(other.status.success());
    assert_eq!(text(&other.stdout), alone);
    assert_eq!(
        text(&other.stderr),
        "the table blur-disc is of published eyes: --patient and --eye change nothing in it\n"
    );
}

#[test]
fn a_file_is_whole_and_standard_output_silent() {
    let files = Files::new();
    // The folder is made, and an older table is replaced.
    let out = files.name("deep/down/eyes.json");
    for _ in 0..2 {
        let output = run(&["measure", "eyes", "--out", &out]);
        let errors = text(&output.stderr);
        assert!(output.status.success(), "{errors}");
        assert_eq!(text(&output.stdout), "");
        assert_eq!(errors, format!("eyes in {out}\n"));
    }
    let written = fs::read_to_string(&out).expect("written");
    assert_eq!(written, said(&["measure", "eyes"]));
    let folder = Path::new(&out).parent().expect("a folder");
    assert_eq!(fs::read_dir(folder).expect("a list").count(), 1);
}

#[test]
fn what_cannot_be_measured_or_written_is_refused() {
    let files = Files::new();
    let precious = files.write("file", b"precious");
    let below = files.name("file/eyes.json");
    refused(
        &["measure", "eyes", "--out", &below],
        &["cannot write", &below],
    );
    let folder = files.0.path().display().to_string();
    refused(
        &["measure", "refraction-function", "--out", &folder],
        &["cannot write", &folder, "not a file"],
    );
    if cfg!(target_os = "linux") {
        for device in ["/dev/null", "/proc/ocularium/eyes.json"] {
            refused(
                &["measure", "eyes", "--out", device],
                &["cannot write", device],
            );
        }
    }
    assert_eq!(fs::read(&precious).expect("still there"), b"precious");
    assert_eq!(fs::read_dir(&folder).expect("a list").count(), 1);

    // A patient is checked also where the table does not depend on one.
    refused(
        &["measure", "mtf", "--patient", "nobody"],
        &["\"nobody\"", "healthy-brown"],
    );
    let patient = files.write("bad.ron", b"(iris_depth_mm: 9.0)");
    let out = files.name("never.json");
    refused(
        &[
            "measure",
            "pupil-ratio",
            "--patient",
            &patient,
            "--out",
            &out,
        ],
        &["bad.ron", "iris_depth_mm", "2.5 to 4.5"],
    );
    assert!(!Path::new(&out).exists());

    misused(&["measure"], "<TABLE>");
    for table in MeasureTable::ALL {
        misused(&["measure", "everything"], table.name());
    }
    misused(&["measure", "eyes", "--out"], "--out");
    misused(&["measure", "eyes", "--out="], "--out");
    misused(&["measure", "eyes", "mtf"], "mtf");
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    // Some 190 kB: far beyond what a pipe holds.
    let mut child = program(&["measure", "glare"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(text(&output.stderr), "");
    assert!(output.status.success(), "{:?}", output.status);
}
