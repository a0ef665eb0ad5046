use super::prints::{
    CHART_LINES, CHART_TEXELS_PER_M, Fonts, chart_canvas, chart_rows, optotype_height_m,
};

#[test]
fn optotypes_have_the_size_that_their_line_says() {
    // 6/6: five minutes of arc at 6 m are 8.727 mm; 6/60 is ten times that.
    assert!((optotype_height_m(0.0) - 8.727e-3).abs() < 1e-6);
    assert!((optotype_height_m(1.0) / optotype_height_m(0.0) - 10.0).abs() < 2e-3);
    let texture = chart_canvas(&Fonts::new().unwrap()).texture(false);
    for ((log_mar, _), (top, size)) in CHART_LINES.iter().zip(chart_rows()) {
        // Ink in the line's own band, measured between first and last dark row left of the labels.
        let dark = |y: u32| {
            (60..texture.width - 130)
                .any(|x| texture.rgba8[((y * texture.width + x) * 4) as usize] < 100)
        };
        let rows: Vec<u32> = (top as u32 - 8..(top + size) as u32 + 9)
            .filter(|&y| dark(y))
            .collect();
        let height = (rows[rows.len() - 1] - rows[0] + 1) as f32;
        let expected =
            6.0 * (5.0 * 10f32.powf(*log_mar) / 60.0).to_radians().tan() * CHART_TEXELS_PER_M;
        assert!(
            (height - expected).abs() <= 1.5,
            "{log_mar}: {height} for {expected}"
        );
    }
}
