// Every size of window and every density of pixels.
import assert from "node:assert/strict";
import { check, MOTION_LIMIT_S, PANELS, published, readState, screenshot, until } from "./harness.mjs";
import * as pixels from "./pixels.mjs";

// Windows by pixel ratio, as width and height in CSS pixels. A driver's emulated screen leaves the page's
// devicePixelContentBoxSize as it is, so densities are those of browsers that were started with them.
export const DENSITIES = [
  { ratio: 3, sizes: [[320, 480], [390, 844]] },
  { ratio: 1.5, sizes: [[844, 390], [768, 1024]], touch: true },
  { ratio: 0.8, sizes: [[1280, 720]] },
];
// At one pixel a point the driver's own windows will do.
const SIZES = [[320, 480], [1280, 720], [3840, 2160]];

const overlap = ([ax, ay, aw, ah], [bx, by, bw, bh]) =>
  Math.max(0, Math.min(ax + aw, bx + bw) - Math.max(ax, bx)) * Math.max(0, Math.min(ay + ah, by + bh) - Math.max(ay, by));
const inside = ([x, y, w, h], width, height) => x >= -0.5 && y >= -0.5 && x + w <= width + 0.5 && y + h <= height + 0.5;

/** What is wrong with where things stand, in words; null when nothing is. */
function misplaced({ panels, places }, width, height) {
  const [eye, view] = PANELS.map((name) => panels[name]);
  if (!eye || !view) return "a panel is missing";
  for (const [name, place] of Object.entries({ eye, view, controls: places.controls ?? [-9, 0, 0, 0] })) {
    if (!inside(place, width, height)) return `${name} is at ${place}`;
  }
  if (overlap(eye, view) > 1) return `the panels overlap: ${eye} and ${view}`;
  const share = (eye[2] * eye[3] + view[2] * view[3]) / (width * height);
  if (share < 0.4) return `the panels have ${(100 * share).toFixed(0)} % of the window`;
  const [smallest] = [eye, view].map(([, , w, h]) => Math.min(w, h)).sort((a, b) => a - b);
  return smallest < 120 ? `a panel is only ${smallest} high or wide` : null;
}

/** Judges a page at its size, which `resize` gives it. */
async function checkSize(page, ratio, resize) {
  const [width, height] = await resize();
  await check(`everything has its place at ${width}×${height} and ${ratio} pixels a point`, async () => {
    let wrong = "it never followed";
    await until(MOTION_LIMIT_S, async () => {
      wrong = misplaced(await readState(page), width, height);
      const canvas = await page.evaluate(() => document.getElementById("ocularium").width);
      if (Math.abs(canvas - width * ratio) > 2) wrong = `the canvas is ${canvas} pixels wide`;
      return wrong === null;
    });
    assert.equal(wrong, null);
    const drawn = await until(MOTION_LIMIT_S, async () => {
      const { panels } = await readState(page);
      const image = await screenshot(page, `size-${width}x${height}-${ratio}.png`);
      const scale = image.width / width;
      const parts = PANELS.map((name) => pixels.crop(image, panels[name].map((side) => side * scale)));
      return parts.every(pixels.isLitPicture);
    });
    assert(drawn, "a panel is dark or uniform");
  });
}

async function checkNothing(page) {
  await check("a window of nothing does no harm", async () => {
    await page.setViewportSize({ width: 1, height: 1 });
    await published(page, 2);
    await page.setViewportSize({ width: 900, height: 600 });
    const back = await until(MOTION_LIMIT_S, async () => misplaced(await readState(page), 900, 600) === null);
    assert(back, `it stays at ${JSON.stringify((await readState(page)).panels)}`);
  });
}

export async function checkSizes(page) {
  for (const [width, height] of SIZES) {
    await checkSize(page, 1, async () => {
      await page.setViewportSize({ width, height });
      return [width, height];
    });
  }
  await checkNothing(page);
}

/** Sizes of a real window of the browser; its own bars take some of the height. */
export async function checkWindows(page, ratio, sizes) {
  const session = await page.context().newCDPSession(page);
  const { windowId } = await session.send("Browser.getWindowForTarget");
  const bars = await page.evaluate(() => window.outerHeight - window.innerHeight);
  for (const [width, height] of sizes) {
    await checkSize(page, ratio, async () => {
      await session.send("Browser.setWindowBounds", { windowId, bounds: { width, height: height + bars } });
      await until(10, () => page.evaluate((wide) => Math.abs(window.innerWidth - wide) <= 1, width));
      return page.evaluate(() => [window.innerWidth, window.innerHeight]);
    });
  }
  await session.detach();
}

/** Makes a page a telephone's, before it is loaded: the agent tells the app that keyboards come up. */
export async function becomeTelephone(page) {
  const session = await page.context().newCDPSession(page);
  const { windowId } = await session.send("Browser.getWindowForTarget");
  await session.send("Browser.setWindowBounds", { windowId, bounds: { width: 390, height: 844 } });
  await session.send("Emulation.setTouchEmulationEnabled", { enabled: true, maxTouchPoints: 5 });
  await session.send("Emulation.setUserAgentOverride", {
    userAgent: "Mozilla/5.0 (Linux; Android 15; Pixel 9) AppleWebKit/537.36 Chrome/145.0.0.0 Mobile Safari/537.36",
  });
}

/** A telephone's page, once it is live. */
export async function checkTelephone(page) {
  await check("a telephone begins with the pictures, and a button for fingers brings the controls", async () => {
    const [width, height] = await page.evaluate(() => [window.innerWidth, window.innerHeight]);
    const { panels, places } = await readState(page);
    assert.equal(misplaced({ panels, places }, width, height), null);
    assert(!places.speed, "the controls are there unasked");
    const share = PANELS.map((name) => panels[name]).reduce((sum, [, , w, h]) => sum + w * h, 0) / (width * height);
    assert(share > 0.75, `the pictures have ${(100 * share).toFixed(0)} % of the screen`);
    const [x, y, w, h] = places.controls;
    assert(w >= 40 && h >= 40, `the button is ${w}×${h} points, too small for a finger`);
    await page.mouse.click(x + w / 2, y + h / 2);
    const opened = await until(MOTION_LIMIT_S, async () => (await readState(page)).places.speed);
    assert(opened, "the controls do not come");
    await screenshot(page, "telephone-controls.png");
    assert.equal(misplaced(await readState(page), width, height), null);
  });
}
