use super::two_point::{
    ALGORITHM_1, GROUPED, GROUPED_SLICE, LIGHT_TASK, LINEAR, POLISHED, PUBLISHED, RIM_TASK, SLICE,
    SOLVER, TABLE, TASK, setting,
};
use super::*;
use crate::optics::refraction_function::RefractionSize;
use crate::optics::refraction_function::domain::RefractionEye;
use std::sync::LazyLock;

const SMALLEST: Effort = Effort {
    pairs: 3_000,
    cases: 2_000,
    irises: 4,
    walks: 1_000,
    grid: 128,
    quick: true,
    warm_up: Duration::from_micros(200),
    measurement: Duration::from_micros(400),
};

/// One run for all tests: times are of no account in it.
static TASKS: LazyLock<Vec<Task>> = LazyLock::new(|| {
    let stopwatch = SMALLEST.stopwatch();
    measure(&SMALLEST, &stopwatch)
});

fn task(name: &str) -> &'static Task {
    let found = TASKS.iter().find(|task| task.name == name);
    found.expect(name)
}

fn row(name: &str, method: &str, parameter: &str) -> &'static ErrorRow {
    task(name).row(method, parameter).expect(method)
}

fn example(name: &str, ns: f64, rms: f64) -> ErrorRow {
    ErrorRow {
        method: name.to_owned(),
        parameter: "1".to_owned(),
        bytes: 0,
        ns_per_call: ns,
        err_max: 3.0 * rms,
        err_p999: 2.0 * rms,
        err_rms: rms,
    }
}

#[test]
fn a_row_sums_its_errors_up() {
    // 0 … 999 in a mixed order and with mixed signs: one case in a thousand lies above 998.
    let errors = (0..1000)
        .map(|i| f64::from(i * 7 % 1000) * if i % 2 == 0 { 1.0 } else { -1.0 })
        .collect();
    let row = ErrorRow::new("m", 3, 0, 1.0, errors);
    assert_eq!((row.err_max, row.err_p999), (999.0, 998.0));
    // Σ i² = 999 · 1000 · 1999/6.
    let expected = (999.0 * 1999.0 / 6.0_f64).sqrt();
    assert!((row.err_rms / expected - 1.0).abs() < 1e-14);
    // Fewer than a thousand: the largest.
    let few = ErrorRow::new("m", 3, 0, 1.0, vec![1.0, -5.0]);
    assert_eq!((few.err_max, few.err_p999), (5.0, 5.0));
    for worthless in [vec![], vec![f64::NAN, 0.0], vec![f64::INFINITY]] {
        let row = ErrorRow::new("m", 3, 0, 1.0, worthless);
        assert!(row.err_max > 1e99 && row.err_rms.is_finite());
    }
}

#[test]
fn the_front_rejects_what_another_beats() {
    let rows = [
        example("slow and exact", 100.0, 1e-6),
        example("dominated in both", 120.0, 1e-3),
        example("fast", 1.0, 1e-1),
        example("as fast and worse", 1.0, 2e-1),
        example("between", 10.0, 1e-2),
        example("its equal", 10.0, 1e-2),
        example("slower and as exact", 101.0, 1e-6),
    ];
    assert_eq!(pareto::front(&rows), [2, 4, 5, 0]);
    assert_eq!(pareto::front(&[]), [0_usize; 0]);
}

#[test]
fn every_task_is_whole() {
    let mut names: Vec<&str> = TASKS.iter().map(|task| task.name.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), TASKS.len());
    for task in TASKS.iter() {
        assert!(
            task.rows.len() >= 3 || task.name == "modulation",
            "{task:?}"
        );
        for row in &task.rows {
            let errors = [row.err_rms, row.err_p999, row.err_max];
            assert!(errors.iter().all(|e| *e >= 0.0 && *e < 1e9), "{row:?}");
            assert!(
                row.err_rms <= row.err_max && row.err_p999 <= row.err_max,
                "{row:?}"
            );
            assert!(
                row.ns_per_call > 0.1 && row.ns_per_call.is_finite(),
                "{row:?}"
            );
            assert!(!row.method.contains(',') && !row.parameter.contains(','));
        }
        let twice = |row: &ErrorRow| {
            let same = |other: &&ErrorRow| {
                (&other.method, &other.parameter) == (&row.method, &row.parameter)
            };
            task.rows.iter().filter(same).count()
        };
        assert!(task.rows.iter().all(|row| twice(row) == 1), "{}", task.name);
    }
}

#[test]
fn the_csv_has_a_line_a_row() {
    let all: usize = TASKS.iter().map(|task| task.rows.len()).sum();
    let joint = joint_csv(&TASKS);
    assert_eq!(joint.lines().count(), all + 1);
    for task in TASKS.iter() {
        let text = task_csv(task);
        assert_eq!(text.lines().count(), task.rows.len() + 1);
        let header = text.lines().next().expect("a header");
        assert_eq!(
            header,
            "method,parameter,bytes,ns_per_call,err_max,err_p999,err_rms,unit"
        );
        assert!(
            text.lines().all(|line| line.matches(',').count() == 7),
            "{text}"
        );
    }
    // The domain is quoted, and comes last.
    for line in joint.lines().skip(1) {
        let (numbers, domain) = line.split_once(",\"").expect("a quoted domain");
        assert_eq!(numbers.matches(',').count(), 8, "{line}");
        assert_eq!(domain.matches('"').count(), 1, "{line}");
    }
    let page = report(&TASKS);
    assert_eq!(page.matches("\n## ").count(), TASKS.len());
}

#[test]
fn pairs_obey_snells_law_within_their_domain() {
    use crate::optics::conicoid::conicoid_normal;
    use crate::optics::snell::snell_refract;
    let eye = RefractionEye::default();
    for (incidence, low, high) in [(Incidence::Domain, 0.0, 80.0), (Incidence::Rim, 80.0, 90.0)] {
        let pairs = two_point::pairs(&eye, incidence, 2_000, 5);
        let mut largest = 0.0_f64;
        for pair in &pairs {
            let normal = conicoid_normal(pair.entry, eye.surface.x, eye.surface.y);
            let angle = normal.dot(pair.light).acos().to_degrees();
            largest = largest.max(angle);
            assert!((low - 1e-6..=high + 1e-6).contains(&angle), "{angle}");
            let ray = snell_refract(-pair.light, normal, 1.0 / eye.index).truncate();
            let way = pair.place.extend(eye.iris_z_mm) - pair.entry;
            // Rounding of a millimetre.
            assert!(way.cross(ray).length() < 1e-14 * way.length() + 1e-14);
            assert!(pair.light.z < 0.0 && pair.place.length() <= eye.limbus_mm);
        }
        assert!(largest > high - 0.5, "the whole domain: {largest}");
        assert_eq!(
            pairs[7].place,
            two_point::pairs(&eye, incidence, 8, 5)[7].place
        );
    }
}

#[test]
fn orders_of_error_in_the_two_point_problem() {
    let [small, large] = [RefractionSize::SMALL, RefractionSize::LARGE].map(setting);
    let rms = |method: &str, parameter: &str| row(TASK, method, parameter).err_rms;
    // The descent stops at its step; the solver does not.
    assert!(rms(SOLVER, "6") < 1e-9 * rms(ALGORITHM_1, "20"));
    assert!(rms(ALGORITHM_1, "20") < rms(ALGORITHM_1, "2"));
    for steps in 0..6_u32 {
        let (now, next) = (
            rms(SOLVER, &steps.to_string()),
            rms(SOLVER, &(steps + 1).to_string()),
        );
        assert!(next <= now, "{steps}: {now} {next}");
    }
    // Cubes of the spacing: at least fourfold from 10 to 280 KB.
    assert!(rms(TABLE, &large) < 0.1 * rms(TABLE, &small));
    assert!(rms(POLISHED, &small) < 0.1 * rms(TABLE, &small));
    // The same bytes as the paper's, and at least ten times the digits.
    assert!(rms(TABLE, &small) < 0.1 * rms(PUBLISHED, "10×100"));
    assert!(row(TASK, TABLE, &small).bytes <= row(TASK, PUBLISHED, "10×100").bytes);
    // Squares where the quadratic has cubes.
    assert!(rms(LINEAR, &large) > 5.0 * rms(TABLE, &large));
    // Fixing the light is the same interpolation but for the rounding of single precision.
    for size in [&small, &large] {
        // As are many at once.
        assert!(
            (rms(GROUPED, size) / rms(TABLE, size) - 1.0).abs() < 0.02,
            "{size}"
        );
        let (fixed, free) = (row(LIGHT_TASK, SLICE, size), row(LIGHT_TASK, TABLE, size));
        let grouped = row(LIGHT_TASK, GROUPED_SLICE, size);
        assert!(
            (grouped.err_rms / fixed.err_rms - 1.0).abs() < 0.02,
            "{grouped:?}"
        );
        assert!(
            (fixed.err_rms / free.err_rms - 1.0).abs() < 0.02,
            "{fixed:?} {free:?}"
        );
    }
    // The rim is steeper than all.
    assert!(row(RIM_TASK, TABLE, &small).err_rms > rms(TABLE, &small));
}

#[test]
fn the_published_table_gains_with_its_size() {
    use super::published_table::PublishedTable;
    use crate::optics::conicoid::conicoid_normal;
    let eye = RefractionEye::default();
    let pairs = two_point::pairs(&eye, Incidence::Domain, 6_000, 6);
    let rms = |table: &PublishedTable, least_cos: f64| {
        let flat = pairs.iter().filter(|pair| {
            conicoid_normal(pair.entry, eye.surface.x, eye.surface.y).dot(pair.light) >= least_cos
        });
        let errors: Vec<f64> = flat
            .map(|pair| {
                let found = table.entry(pair.place, pair.light);
                found.distance_squared(pair.entry)
            })
            .collect();
        (errors.iter().sum::<f64>() / errors.len() as f64).sqrt()
    };
    let coarse = PublishedTable::new(&eye, 10, 100);
    let fine = PublishedTable::new(&eye, 20, 400);
    assert_eq!(coarse.bytes(), 12_000);
    for (least_cos, low, high) in [(0.6, 0.15, 0.35), (0.0, 0.3, 0.9)] {
        let (coarse, fine) = (rms(&coarse, least_cos), rms(&fine, least_cos));
        println!(
            "as published, cosine from {least_cos}: {coarse:.4}, of twice the sides {fine:.4}"
        );
        // Linear: a quarter where the map is smooth, little gained at its rim.
        assert!((low..high).contains(&(fine / coarse)));
    }
    // Exact at a sample: the axis, from straight ahead, on an odd grid.
    let table = PublishedTable::new(&eye, 3, 9);
    let at = table.entry(glam::DVec2::ZERO, glam::DVec3::NEG_Z);
    assert!(at.length() < 1e-6, "{at}");
    for odd in [f64::NAN, f64::INFINITY, -1e300] {
        let light = glam::DVec3::new(odd, 0.0, -1.0);
        // Out of the domain, but no panic.
        table.entry(glam::DVec2::splat(odd), light);
    }
}

#[test]
fn orders_of_error_in_the_other_tasks() {
    let rms = |name: &str, method: &str, parameter: &str| row(name, method, parameter).err_rms;
    let falls = |name: &str, method: &str, parameters: &[&str]| {
        let errors: Vec<f64> = parameters.iter().map(|p| rms(name, method, p)).collect();
        assert!(
            errors.is_sorted_by(|a, b| a > b),
            "{name} {method}: {errors:?}"
        );
    };
    falls("wavelengths", "Gauss nodes", &["4", "5", "6", "8"]);
    assert_eq!(rms("wavelengths", "every 10 nm", "41"), 0.0);
    // Bilinear: a quarter of the error for twice the sides.
    falls(
        "iris-table",
        "table",
        &["8×4", "16×8", "32×16", "64×32", "128×64"],
    );
    assert_eq!(rms("iris-table", "many fluxes", "16"), 0.0);
    falls(
        "iris-reflectance",
        "many fluxes",
        &["1", "2", "4", "8", "16"],
    );
    assert!(rms("iris-reflectance", "many fluxes", "16") < 1e-5);
    assert!(rms("iris-reflectance", "two-flux", "2") < 0.05);
    assert!(
        rms("iris-reflectance", "two-flux", "2")
            < rms("iris-reflectance", "single scattering", "closed form")
    );
    falls("iris-reflectance", "random walks", &["100", "1000"]);
    falls(
        "segment",
        "march",
        &["1", "4", "16", "64", "256", "1024", "4096"],
    );
    assert!(row("segment", "closed form", "exact").err_max < 1e-13);
    // A wavelength a channel, then four and a matrix, as the module's table has it.
    assert!(row("tear-film", "a wavelength a channel", "3").err_max < 1.4e-2);
    assert!(row("tear-film", "wavelengths and a matrix", "4").err_max < 1.3e-4);
    falls("tear-film", "table", &["8×8", "16×16", "32×32", "64×64"]);
    let simple = |parameter: &str| rms("blur-disc", "simple angle", parameter);
    let aberrated = rms("blur-disc", "with spherical aberration", "c40 and c60");
    assert!(aberrated < 0.1 * simple("from the pupil"));
    assert!(simple("from the best focus") < simple("from the pupil"));
    assert_eq!(rms("blur-disc", "traced", "48 rays"), 0.0);
    falls(
        "glare-energy",
        "quadrature",
        &["8", "16", "32", "64", "128", "256"],
    );
    assert!(row("glare-energy", "closed form", "exact").err_max < 1e-11);
    let equation = |parameter: &str| rms("glare-equations", "equation", parameter);
    assert!(equation("general") < equation("Stiles–Holladay") && equation("total") == 0.0);
    falls("modulation", "grid", &["64", "128"]);
    falls("wavefront", "random rays", &["32", "64", "192"]);
    // On rings the weights are a quadrature's, and the whole pupil counts.
    assert!(rms("wavefront", "rays on rings", "192") < 0.02);
}

#[test]
fn requirements_compare_and_say_what_is_missing() {
    let found = requirements(&TASKS);
    let of = |name: &str| {
        let one = found.iter().find(|one| one.name.starts_with(name));
        one.expect(name)
    };
    for one in &found {
        println!("{one}");
        assert!(one.found.is_some(), "{one}");
        let kept = if one.at_least {
            one.found >= Some(one.limit)
        } else {
            one.found <= Some(one.limit)
        };
        assert_eq!(kept, one.met, "{one}");
        assert_eq!(one.to_string().contains("NOT MET"), !one.met);
    }
    // What does not hang on the clock.
    assert!(of("solver: times smaller").met && of("tables of the core").met);
    assert!(of("small refraction function: bytes").met);
    let nothing = requirements(&[]);
    assert_eq!(nothing.len(), found.len());
    assert_eq!(nothing.iter().filter(|one| one.met).count(), 1);
    let sum: usize = tables_at_run_time().iter().map(|table| table.bytes).sum();
    assert_eq!(of("tables of the core").found, Some(sum as f64));
}

#[test]
fn a_stopwatch_tells_long_from_short() {
    let stopwatch = Effort {
        warm_up: Duration::from_millis(5),
        measurement: Duration::from_millis(20),
        ..SMALLEST
    }
    .stopwatch();
    let cases: Vec<f64> = (1..=5).map(f64::from).collect();
    let run = |turns: u32| {
        let turn = |x: &f64| (0..turns).fold(*x, |x, _| (x * 1.7).sqrt());
        stopwatch.ns_per_call(&cases, turn)
    };
    let (short, long) = (run(10), run(1000));
    println!("10 roots {short:.1} ns, 1000 roots {long:.0} ns");
    // A hundredfold, whatever else the machine does.
    assert!(long > 20.0 * short && short > 1.0);
    // One call that outlasts all that was asked for is still measured.
    let nap = || std::thread::sleep(Duration::from_millis(3));
    let slept = stopwatch.ns_per_case(2, nap);
    assert!((1.5e6..15e6).contains(&slept), "{slept} ns");
}
