//! `features`: the corners of an image.

use super::arguments::FeatureArgs;
use super::sentences::{complain, say, unwritten};
use crate::percept::fast;
use crate::scene::photo::read_named_file;
use crate::scene::picture_file::{Meaning, decode_picture, on_white};
use image::DynamicImage;
use std::error::Error;
use std::io::{BufWriter, Write};

pub(super) fn features(arguments: &FeatureArgs) -> Result<(), Box<dyn Error>> {
    let name = arguments.image.display().to_string();
    let bytes = read_named_file(&arguments.image, "image")?;
    let picture = decode_picture(&bytes, &name, 7, Meaning::Colour)?;
    for remark in &picture.remarks {
        complain(remark);
    }
    let image = DynamicImage::ImageRgb16(on_white(picture.image)).into_rgb8();
    let grey: Vec<u8> = image
        .pixels()
        .map(|pixel| fast::luma_of_srgb8(pixel.0))
        .collect();
    let corners = fast::detect(
        &grey,
        image.width() as usize,
        image.height() as usize,
        arguments.threshold,
        !arguments.no_nms,
    )?;
    let mut out = BufWriter::new(std::io::stdout().lock());
    say(&mut out, "x,y,score")?;
    for corner in &corners {
        say(
            &mut out,
            &format!("{},{},{}", corner.x, corner.y, corner.score),
        )?;
    }
    match out.flush() {
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        Err(error) => Err(unwritten(&error).into()),
        Ok(()) => Ok(()),
    }
}
