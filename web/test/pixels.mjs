// What the browser test asks of a picture: is a region lit and not uniform, have two regions changed.
// Values are 8-bit sRGB as screenshots have them.
import { PNG } from "pngjs";

/** A region is lit when its mean luma is at least this (a closed lid over the view is below it). */
export const LIT_MEAN = 6;
/** A region is a picture, not a flat colour, when the standard deviation of its luma is at least this. */
export const PICTURE_DEVIATION = 4;
/** A pixel has changed when one of its channels differs by more than this (dithering does not). */
export const CHANNEL_STEP = 6;
/** A region has changed when at least this fraction of its pixels has. */
export const CHANGED_FRACTION = 0.001;

/** Decodes a PNG to `{ width, height, data }`, data being RGBA bytes. */
export function decode(bytes) {
  return PNG.sync.read(bytes);
}

/** The part of an image under `[x, y, width, height]`; what lies outside of the image is left out. */
export function crop(image, [x, y, width, height]) {
  const left = Math.max(0, Math.ceil(x));
  const top = Math.max(0, Math.ceil(y));
  const right = Math.min(image.width, Math.floor(x + width));
  const bottom = Math.min(image.height, Math.floor(y + height));
  if (!(right > left && bottom > top)) throw new Error(`the region ${[x, y, width, height]} is empty`);
  const part = { width: right - left, height: bottom - top };
  part.data = Buffer.alloc(4 * part.width * part.height);
  for (let row = 0; row < part.height; row += 1) {
    const start = 4 * ((top + row) * image.width + left);
    image.data.copy(part.data, 4 * row * part.width, start, start + 4 * part.width);
  }
  return part;
}

/** Mean and standard deviation of luma (Rec. 709 weights on the encoded values). */
export function brightness({ data }) {
  let sum = 0;
  let squares = 0;
  for (let i = 0; i < data.length; i += 4) {
    const luma = 0.2126 * data[i] + 0.7152 * data[i + 1] + 0.0722 * data[i + 2];
    sum += luma;
    squares += luma * luma;
  }
  const count = data.length / 4;
  const mean = sum / count;
  return { mean, deviation: Math.sqrt(Math.max(0, squares / count - mean * mean)) };
}

/** Whether the image is lit and not uniform. */
export function isLitPicture(image) {
  const { mean, deviation } = brightness(image);
  return mean >= LIT_MEAN && deviation >= PICTURE_DEVIATION;
}

/** The fraction of pixels that differ between two images of one size. */
export function changedFraction(a, b) {
  if (a.width !== b.width || a.height !== b.height) throw new Error("the images differ in size");
  let changed = 0;
  for (let i = 0; i < a.data.length; i += 4) {
    const step = Math.max(
      Math.abs(a.data[i] - b.data[i]),
      Math.abs(a.data[i + 1] - b.data[i + 1]),
      Math.abs(a.data[i + 2] - b.data[i + 2]),
    );
    if (step > CHANNEL_STEP) changed += 1;
  }
  return changed / (a.data.length / 4);
}

/** Whether two images of one size show something different. */
export function haveChanged(a, b) {
  return changedFraction(a, b) >= CHANGED_FRACTION;
}

/** Where the pixels `[r, g, b]` that are wanted lie on the mean, from 0 (left) to 1; `null` of too few to say. */
export function middleOf({ data, width }, wanted) {
  let sum = 0;
  let count = 0;
  for (let i = 0; i < data.length; i += 4) {
    if (wanted([data[i], data[i + 1], data[i + 2]])) {
      sum += (((i / 4) % width) + 0.5) / width;
      count += 1;
    }
  }
  return count < 20 ? null : sum / count;
}
