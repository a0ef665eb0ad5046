// Every size of window and every density of pixels.
import assert from "node:assert/strict";
import { check, MOTION_LIMIT_S, PANELS, published, READY_LIMIT_S, readState, screenshot, setPaused, until } from "./harness.mjs";
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
    // A lid may be shut in one picture and another takes a slow machine half a minute at 4K.
    let tries = 0;
    const drawn = await until(2 * READY_LIMIT_S, async () => {
      tries += 1;
      const { panels } = await readState(page);
      const image = await screenshot(page, `size-${width}x${height}-${ratio}.png`);
      const scale = image.width / width;
      const parts = PANELS.map((name) => pixels.crop(image, panels[name].map((side) => side * scale)));
      return parts.every(pixels.isLitPicture);
    });
    assert(drawn, `a panel is dark or uniform, ${tries} times`);
  });
}

async function checkNothing(page) {
  await check("a window of nothing does no harm", async () => {
    await page.setViewportSize({ width: 1, height: 1 });
    await published(page, 2);
    await page.setViewportSize({ width: 900, height: 600 });
    // What was begun at 4K is drawn before.
    const back = await until(2 * READY_LIMIT_S, async () => misplaced(await readState(page), 900, 600) === null);
    assert(back, `it stays at ${JSON.stringify((await readState(page)).panels)}`);
  });
}

export async function checkSizes(page) {
  for (const [width, height] of SIZES) {
    // Of the largest one picture will do, which takes a software rasteriser long enough.
    const isLargest = width === SIZES.at(-1)[0];
    if (isLargest) await setPaused(page, true);
    await checkSize(page, 1, async () => {
      await page.setViewportSize({ width, height });
      return [width, height];
    });
  }
  await check("controls grow with a screen that nobody else enlarges", async () => {
    const [width] = SIZES.at(-1);
    const { places, panels } = await readState(page);
    // The controls' usual width is 264 points.
    const beside = width - (panels.view[0] + panels.view[2]);
    assert(Math.abs(beside - 2 * 264) < 40, `the controls are ${beside} points wide`);
    assert(places.controls[2] >= 40, `the button is ${places.controls[2]} points wide`);
  });
  await checkNothing(page);
  await setPaused(page, false);
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

const middle = ([x, y, w, h]) => [x + w / 2, y + h / 2];

/** Fingers at `[[x, y], …]`; none lifts them. */
async function fingers(session, type, places) {
  const touchPoints = places.map(([x, y], id) => ({ x, y, id, radiusX: 5, radiusY: 5, force: 0.5 }));
  await session.send("Input.dispatchTouchEvent", { type, touchPoints });
}

/** Moves fingers along straight lines, slowly enough for a frame or two between steps. */
async function glide(page, session, from, to, steps = 4) {
  await fingers(session, "touchStart", from);
  await published(page, 1);
  for (let step = 1; step <= steps; step += 1) {
    const share = step / steps;
    const places = from.map(([x, y], i) => [x + share * (to[i][0] - x), y + share * (to[i][1] - y)]);
    await fingers(session, "touchMove", places);
    await published(page, 1);
  }
  await fingers(session, "touchEnd", []);
  await published(page, 2);
}

/** A tap, as short as one is (a frame may take longer) or resting for some frames. */
async function tap(page, session, place, resting = 0) {
  await fingers(session, "touchStart", [place]);
  if (resting > 0) await published(page, resting);
  await fingers(session, "touchEnd", []);
  await published(page, 3);
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

/** A telephone's page, once it is live, under fingers. */
export async function checkTelephone(page) {
  const session = await page.context().newCDPSession(page);
  await check("a telephone begins with the pictures, and a tap brings the controls", async () => {
    const [width, height] = await page.evaluate(() => [window.innerWidth, window.innerHeight]);
    const { panels, places } = await readState(page);
    assert.equal(misplaced({ panels, places }, width, height), null);
    assert(!places.speed, "the controls are there unasked");
    const share = PANELS.map((name) => panels[name]).reduce((sum, [, , w, h]) => sum + w * h, 0) / (width * height);
    assert(share > 0.75, `the pictures have ${(100 * share).toFixed(0)} % of the screen`);
    const [, , w, h] = places.controls;
    assert(w >= 40 && h >= 40, `the button is ${w}×${h} points, too small for a finger`);
    await tap(page, session, middle(places.controls));
    const opened = await until(20, async () => (await readState(page)).places.speed);
    assert(opened, "the controls do not come");
    await screenshot(page, "telephone-controls.png");
    assert.equal(misplaced(await readState(page), width, height), null);
  });
  await check("one finger turns the eye, two come nearer, and the page itself does not zoom", async () => {
    const before = await readState(page);
    const [x, y] = middle(before.panels.eye);
    await glide(page, session, [[x - 60, y]], [[x + 60, y + 20]]);
    const turned = await readState(page);
    assert(turned.orbit[0] - before.orbit[0] > 10, `the eye turned from ${before.orbit} to ${turned.orbit}`);
    await glide(page, session, [[x - 25, y], [x + 25, y]], [[x - 75, y], [x + 75, y]]);
    const nearer = await readState(page);
    assert(nearer.orbit[2] < 0.7 * turned.orbit[2], `the distance went from ${turned.orbit[2]} to ${nearer.orbit[2]} mm`);
    assert(Math.abs(nearer.orbit[0] - turned.orbit[0]) < 8, `the pinch turned the eye by ${nearer.orbit[0] - turned.orbit[0]}°`);
    assert.equal(await page.evaluate(() => window.visualViewport.scale), 1, "the page zoomed");
  });
  await check("a finger moves a slider, also one that rested first", async () => {
    const { places, speed } = await readState(page);
    const [x, y, w, h] = places.speed;
    await glide(page, session, [[x + 0.3 * w, y + h / 2]], [[x + 4, y + h / 2]]);
    const moved = (await readState(page)).speed;
    assert(moved < 0.5 * speed, `the speed went from ${speed} to ${moved}`);
  });
  await check("a keyboard comes up for the seed, after a tap that rests", async () => {
    await tap(page, session, middle((await readState(page)).places.seed), 3);
    const focused = () => page.evaluate(() => document.activeElement.tagName);
    const up = await until(20, async () => (await focused()) === "INPUT");
    assert(up, `the focus is on ${await focused()}`);
    await page.keyboard.type("42");
    await page.keyboard.press("Enter");
    const obeyed = await until(20, async () => /42/.test((await readState(page)).seed));
    assert(obeyed, `the seed is ${(await readState(page)).seed}`);
    const scrolled = await page.evaluate(() => [scrollX, scrollY, document.getElementById("stage").scrollTop]);
    assert.deepEqual(scrolled, [0, 0, 0], "the page has moved under the finger");
  });
  await session.detach();
}
