use super::*;

fn row(method: &str, parameter: &str, ns: f64, rms: f64) -> ErrorRow {
    ErrorRow {
        method: method.to_owned(),
        parameter: parameter.to_owned(),
        bytes: 12,
        ns_per_call: ns,
        err_max: 4.0 * rms,
        err_p999: 3.0 * rms,
        err_rms: rms,
    }
}

fn task(rows: Vec<ErrorRow>) -> Task {
    Task {
        name: "example".to_owned(),
        title: "R < 1 & \"more\"".to_owned(),
        call: String::new(),
        domain: String::new(),
        reference: String::new(),
        unit: "mm".to_owned(),
        rows,
    }
}

/// The names of all elements of an XML text; panics where it is not well-formed (as far as an SVG of
/// ours goes: elements, attributes in double quotes, text, five entities).
fn elements(xml: &str) -> Vec<String> {
    let mut open: Vec<&str> = Vec::new();
    let mut all = Vec::new();
    let mut rest = xml.trim();
    while !rest.is_empty() {
        let start = rest.find('<').expect("an element");
        let (text, tag) = rest.split_at(start);
        for part in text.split('&').skip(1) {
            let entity = part.split_once(';').expect("an entity").0;
            assert!(
                ["amp", "lt", "gt", "quot", "apos"].contains(&entity),
                "{entity}"
            );
        }
        assert!(
            text.trim().is_empty() || !open.is_empty(),
            "text outside: {text}"
        );
        let end = tag.find('>').expect("the tag's end");
        let inside = &tag[1..end];
        rest = &tag[end + 1..];
        if let Some(name) = inside.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name), "closes what is open");
            continue;
        }
        let closed = inside.ends_with('/');
        let inside = inside.trim_end_matches('/');
        let (name, attributes) = inside.split_once(' ').unwrap_or((inside, ""));
        // name="value" …: between the quotes alternate names and values.
        let parts: Vec<&str> = attributes.split('"').collect();
        assert!(
            parts.len() % 2 == 1 && !attributes.contains('<'),
            "{inside}"
        );
        for name in parts
            .iter()
            .step_by(2)
            .filter(|part| !part.trim().is_empty())
        {
            let name = name.trim().strip_suffix('=').expect("name=");
            assert!(
                name.chars()
                    .all(|c| c.is_alphanumeric() || "-:".contains(c)),
                "{name}"
            );
        }
        all.push(name.to_owned());
        if !closed {
            open.push(name);
        }
    }
    assert!(open.is_empty(), "left open: {open:?}");
    all
}

#[test]
fn the_svg_is_well_formed() {
    let rows = vec![
        row("a < b", "1", 30.0, 1e-3),
        row("a < b", "2 & 3", 40.0, 0.0),
        row("c", "4", 5e6, 2.0),
    ];
    let svg = plot(&task(rows));
    let names = elements(&svg);
    assert_eq!(names[0], "svg");
    // A circle a row, and one a method in the legend.
    assert_eq!(names.iter().filter(|name| *name == "circle").count(), 3 + 2);
    assert_eq!(names.iter().filter(|name| *name == "polyline").count(), 1);
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    assert!(svg.contains("R &lt; 1 &amp; &quot;more&quot;"));
}

#[test]
#[should_panic(expected = "closes what is open")]
fn the_checker_can_fail() {
    elements("<svg><g></svg>");
}

#[test]
fn extremes_can_be_drawn() {
    for rows in [
        vec![],
        vec![row("one", "1", 1.0, 0.0)],
        vec![
            row("worthless", "1", 1.0, 1e100),
            row("good", "2", 1e9, 1e-16),
        ],
    ] {
        let svg = plot(&task(rows));
        elements(&svg);
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }
}

#[test]
fn what_has_no_error_stands_on_a_line_of_its_own() {
    let with = plot(&task(vec![
        row("m", "1", 1.0, 1e-3),
        row("m", "2", 9.0, 0.0),
    ]));
    let without = plot(&task(vec![
        row("m", "1", 1.0, 1e-3),
        row("m", "2", 9.0, 1e-4),
    ]));
    let zero = |svg: &str| svg.matches(">0</text>").count();
    assert_eq!((zero(&with), zero(&without)), (1, 0));
    // 1e-4, where it stands, is not written there.
    assert!(!with.contains(">10⁻⁴<") && without.contains(">10⁻⁴<"));
}

#[test]
fn filled_marks_are_the_front() {
    let svg = plot(&task(vec![
        row("m", "1", 10.0, 1e-2),
        row("m", "2", 20.0, 1e-1),
        row("m", "3", 30.0, 1e-3),
    ]));
    let hollow = svg.matches(r##"fill="#ffffff" stroke="##).count();
    assert_eq!(hollow, 1, "the second is slower and worse than the first");
    let line = svg.split("<polyline points=\"").nth(1).expect("a line");
    let points = line.split('"').next().expect("its points");
    assert_eq!(points.split(' ').count(), 2);
}

#[test]
fn labels_do_not_overlap() {
    // As crowded as the two-point problem: tables within a factor of 1.4 in time.
    let marks: Vec<Mark> = (0..26)
        .map(|i| {
            let i = f64::from(i);
            let y = 160.0 + 13.0 * i;
            Mark {
                x: 200.0 + 40.0 * (i * 0.618).fract() + if i > 16.0 { 300.0 } else { 0.0 },
                y,
                top: y - 25.0,
                label: "40×24×77".to_owned(),
            }
        })
        .collect();
    let frame = Frame {
        left: 74.0,
        right: 878.0,
        top: 80.0,
        bottom: 520.0,
    };
    let labels = place(&marks, frame);
    assert_eq!(labels.len(), marks.len());
    for (i, label) in labels.iter().enumerate() {
        for other in &labels[..i] {
            assert!(label.rect.overlap(&other.rect) == 0.0, "{i}");
        }
        let inside = label.rect.overlap(&frame);
        assert!((inside - labels::width("40×24×77", labels::FONT_PX) * 14.0).abs() < 1e-6);
    }
}

#[test]
fn ticks_read_well() {
    assert_eq!(time(1.0), "1 ns");
    assert_eq!(time(200.0), "200 ns");
    assert_eq!(time(5e4), "50 µs");
    assert_eq!(time(1e9), "1 s");
    assert_eq!(time(0.5), "0.5 ns");
    assert_eq!(power(1e-12), "10⁻¹²");
    assert_eq!(power(5e-3), "5·10⁻³");
    assert_eq!(power(0.05), "0.05");
    assert_eq!(power(100.0), "100");
    let axis = Axis::new([1.0, 1e6].into_iter(), [0.0, 100.0], true);
    // Room for a mark on the outermost values.
    assert_eq!(axis.ticks().len(), 9);
    // 1e-17 to 1: every second decade.
    let long = Axis::new([1e-17, 1.0].into_iter(), [0.0, 100.0], true);
    assert!((8..=12).contains(&long.ticks().len()), "{:?}", long.ticks());
}
