//! The one rule by which a picture is halved.

/// The next level of a picture of this width and height, whose texels are numbered row by row: the mean of two by two texels. Where a side is odd
/// the last box takes the spare texel in, so no texel is lost and none counts twice.
pub fn halved<const N: usize>(
    (width, height): (usize, usize),
    texel_at: impl Fn(usize) -> [f32; N],
) -> ((usize, usize), Vec<[f32; N]>) {
    let size = ((width / 2).max(1), (height / 2).max(1));
    let span = |index: usize, out: usize, of: usize| {
        let end = if index + 1 == out { of } else { 2 * index + 2 };
        (2 * index).min(of - 1)..end
    };
    let mut out = Vec::with_capacity(size.0 * size.1);
    for y in 0..size.1 {
        for x in 0..size.0 {
            let (mut sum, mut count) = ([0.0f32; N], 0.0f32);
            for v in span(y, size.1, height) {
                for u in span(x, size.0, width) {
                    let texel = texel_at(v * width + u);
                    sum = std::array::from_fn(|k| sum[k] + texel[k]);
                    count += 1.0;
                }
            }
            out.push(sum.map(|total| total / count));
        }
    }
    (size, out)
}

/// One level: width, height, texels row by row.
pub type Level<const N: usize> = (u32, u32, Vec<[f32; N]>);

/// A picture and all its halves down to one texel, the finest first.
pub fn chain<const N: usize>(
    (width, height): (usize, usize),
    texels: Vec<[f32; N]>,
) -> Vec<Level<N>> {
    let mut size = (width, height);
    let mut levels = vec![(width as u32, height as u32, texels)];
    while size != (1, 1) {
        let last = &levels[levels.len() - 1].2;
        let (next, texels) = halved(size, |i| last[i]);
        levels.push((next.0 as u32, next.1 as u32, texels));
        size = next;
    }
    levels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_is_kept_and_a_spare_texel_counts_once() {
        let texels: Vec<[f32; 2]> = (0..8u8).map(|i| [f32::from(i), 1.0]).collect();
        let (size, half) = halved((4, 2), |i| texels[i]);
        assert_eq!((size, half), ((2, 1), vec![[2.5, 1.0], [4.5, 1.0]]));
        // Five by one: two and three.
        let texels: Vec<[f32; 1]> = [1.0, 3.0, 2.0, 4.0, 9.0].map(|x| [x]).into();
        assert_eq!(halved((5, 1), |i| texels[i]), ((2, 1), vec![[2.0], [5.0]]));
        assert_eq!(halved((1, 1), |_| [7.0f32]), ((1, 1), vec![[7.0]]));
        // Whatever the sizes, weights are those of the boxes.
        let texels: Vec<[f32; 1]> = (0..15u8).map(|i| [f32::from(i)]).collect();
        let (size, half) = halved((3, 5), |i| texels[i]);
        assert_eq!(size, (1, 2));
        assert_eq!(half, [[2.5], [10.0]]);
    }

    #[test]
    fn a_chain_ends_in_one_texel_that_is_the_mean() {
        let texels = (0..32u8).map(|i| [f32::from(i), 1.0]).collect();
        let levels = chain((8, 4), texels);
        let sizes: Vec<_> = levels.iter().map(|level| (level.0, level.1)).collect();
        assert_eq!(sizes, [(8, 4), (4, 2), (2, 1), (1, 1)]);
        // Exact: the mean of 0..31 by halves of powers of two.
        assert_eq!(levels[3].2, [[15.5, 1.0]]);
        let odd = chain((21, 9), vec![[0.25f32]; 189]);
        assert_eq!(odd.last().map(|level| level.2.clone()), Some(vec![[0.25]]));
    }
}
