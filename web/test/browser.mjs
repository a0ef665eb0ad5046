// Loads web/dist in headless Chromium on software WebGPU and judges it as a visitor would: it starts,
// both panels show a moving picture, keys and resizing work, nothing is reported in the console, and
// where WebGPU is missing the page says so. `./dev web-test` builds the page, then runs this.
//
// Leaves screenshots and report.json in out/web. CHROMIUM names the browser.
import assert from "node:assert/strict";
import { mkdir, readFile, writeFile } from "node:fs/promises";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { DIST, serve } from "../serve.mjs";
import { checkDeviceLoss, checkHiding, DEVICES, SLEEPER } from "./device.mjs";
import {
  check,
  launch,
  MOTION_LIMIT_S,
  openPage,
  OUT,
  PANELS,
  pause,
  published,
  READY_LIMIT_S,
  readState,
  report,
  screenshot,
  SOFTWARE_WEBGPU,
  tally,
  until,
  VIEWPORT,
} from "./harness.mjs";
import { checkOwn } from "./own.mjs";
import { checkChoices, checkConditions, checkWalk } from "./people.mjs";
import * as pixels from "./pixels.mjs";
import { becomeTelephone, checkSizes, checkTelephone, checkWindows, DENSITIES } from "./sizes.mjs";

// ---- The comparators can fail -------------------------------------------------------------------

function image(width, height, colourAt) {
  const data = Buffer.alloc(4 * width * height, 255);
  for (let i = 0; i < width * height; i += 1) data.set(colourAt(i % width, Math.floor(i / width)), 4 * i);
  return { width, height, data };
}

async function checkComparators() {
  const ramp = image(64, 64, (x) => [4 * x, 4 * x, 4 * x]);
  await check("comparator: a gradient is a lit picture", () => assert(pixels.isLitPicture(ramp)));
  await check("comparator: uniform and nearly black images are not", () => {
    assert(!pixels.isLitPicture(image(64, 64, () => [128, 128, 128])));
    assert(!pixels.isLitPicture(image(64, 64, (x) => [x % 3, x % 2, 0])));
  });
  await check("comparator: equal or barely dithered images have not changed", () => {
    assert(!pixels.haveChanged(ramp, ramp));
    const dithered = image(64, 64, (x, y) => [4 * x, Math.max(0, 4 * x - ((x + y) % 3)), 4 * x]);
    assert(!pixels.haveChanged(ramp, dithered));
  });
  await check("comparator: a moved edge is a change, other sizes are an error", () => {
    assert(pixels.haveChanged(ramp, image(64, 64, (x) => [4 * Math.max(0, x - 2), 4 * x, 4 * x])));
    assert.throws(() => pixels.haveChanged(ramp, image(32, 64, () => [0, 0, 0])));
  });
  await check("comparator: a crop keeps its pixels and never leaves the image", () => {
    const part = pixels.crop(ramp, [60, -5, 20, 10]);
    assert.deepEqual([part.width, part.height, part.data[0]], [4, 5, 240]);
    assert.throws(() => pixels.crop(ramp, [70, 0, 10, 10]));
  });
}

// ---- The app --------------------------------------------------------------------------------------

async function checkStart(page, url, name = "first live frame") {
  await check(`${name} within ${READY_LIMIT_S} s`, async () => {
    const start = Date.now();
    await page.goto(url);
    const verdict = await page
      .waitForFunction(
        () => (window.oculariumReady === true && "ready") || ("failed" in document.documentElement.dataset && "failed"),
        null,
        { timeout: 1000 * READY_LIMIT_S, polling: 100 },
      )
      .then((handle) => handle.jsonValue())
      .catch(() => "nothing happened");
    const passed = (Date.now() - start) / 1000;
    report.first_live_frame_s ??= passed;
    const message = await page.locator("#message").textContent();
    if (verdict !== "ready") await screenshot(page, "not-ready.png");
    assert.equal(verdict, "ready", `${verdict}, the page says: ${message}`);
    console.log(`               first live frame after ${passed.toFixed(1)} s`);
  });
}

async function checkState(page) {
  await check("the published state is finite and its clock runs", async () => {
    const before = await readState(page);
    assert(Number.isFinite(before.time_s) && before.time_s >= 0, `time_s is ${before.time_s}`);
    assert(before.lid_aperture >= 0 && before.lid_aperture <= 1, `lid_aperture is ${before.lid_aperture}`);
    for (const [name, [x, y, w, h]] of Object.entries(before.panels)) {
      const inside = x >= 0 && y >= 0 && x + w <= VIEWPORT.width + 1 && y + h <= VIEWPORT.height + 1;
      assert(inside && w > 100 && h > 100, `panel ${name} is at ${[x, y, w, h]}`);
    }
    const runs = await until(MOTION_LIMIT_S, async () => (await readState(page)).time_s > before.time_s);
    assert(runs, `time_s stays at ${before.time_s}`);
  });
}

/** A screenshot, saved under `name` and cut into the panels. */
async function cropPanels(page, name) {
  const { panels } = await readState(page);
  const whole = await screenshot(page, name);
  return Object.fromEntries(PANELS.map((panel) => [panel, pixels.crop(whole, panels[panel])]));
}

async function checkPictures(page) {
  await check("the page's notice is gone", async () => {
    const gone = await until(MOTION_LIMIT_S, () =>
      page.evaluate(() => getComputedStyle(document.getElementById("notice")).opacity === "0"),
    );
    assert(gone, "it still covers the panels");
  });
  // A blink darkens the view for a moment, so each panel has several tries.
  const lit = {};
  const changed = { eye: 0, view: 0 };
  await until(MOTION_LIMIT_S, async () => {
    const first = await cropPanels(page, "first.png");
    await pause(1000);
    const second = await cropPanels(page, "one-second-later.png");
    for (const panel of PANELS) {
      if (!lit[panel]?.good) lit[panel] = { good: pixels.isLitPicture(first[panel]), ...pixels.brightness(first[panel]) };
      changed[panel] = Math.max(changed[panel], pixels.changedFraction(first[panel], second[panel]));
    }
    return PANELS.every((panel) => lit[panel].good && changed[panel] >= pixels.CHANGED_FRACTION);
  });
  report.panels = { lit, changed };
  for (const panel of PANELS) {
    await check(`the ${panel} panel is lit and not uniform`, () => {
      const { good, mean, deviation } = lit[panel];
      assert(good, `mean ${mean.toFixed(1)}, standard deviation ${deviation.toFixed(1)}`);
    });
    await check(`the ${panel} panel moves within a second`, () => {
      assert(changed[panel] >= pixels.CHANGED_FRACTION, `at most ${changed[panel]} of its pixels changed`);
    });
  }
}

async function checkControls(page) {
  await check("the space bar pauses and resumes", async () => {
    assert.equal(await page.evaluate(() => document.activeElement.id), "ocularium", "the canvas has no focus");
    await page.keyboard.press("Space");
    await published(page, 2);
    const stopped = await readState(page);
    await published(page, 2);
    assert.equal((await readState(page)).time_s, stopped.time_s, "the clock still runs after the space bar");
    await page.keyboard.press("Space");
    const resumes = await until(MOTION_LIMIT_S, async () => (await readState(page)).time_s > stopped.time_s);
    assert(resumes, "the clock does not resume");
  });
  await check("the panels follow the window's size", async () => {
    const small = { width: 900, height: 600 };
    await page.setViewportSize(small);
    const fits = await until(MOTION_LIMIT_S, async () => {
      const { panels } = await readState(page);
      return Object.values(panels).every(([x, y, w, h]) => x + w <= small.width + 1 && y + h <= small.height + 1);
    });
    assert(fits, `panels at ${JSON.stringify((await readState(page)).panels)}`);
    const redrawn = await until(MOTION_LIMIT_S, async () =>
      Object.values(await cropPanels(page, "resized.png")).every(pixels.isLitPicture),
    );
    assert(redrawn, "a panel stays dark or uniform");
  });
}

// ---- Where it cannot run ------------------------------------------------------------------------

async function checkSentence(browser, url, { name, setUp, wanted }) {
  await check(name, async () => {
    const { page } = await openPage(browser);
    await setUp?.(page);
    await page.goto(url);
    await page.waitForSelector("[data-failed] #message", { timeout: 30000 });
    const sentence = await page.locator("#message").textContent();
    for (const pattern of wanted) assert.match(sentence, pattern);
    assert.equal(sentence.match(/\.(\s|$)/g)?.length, 1, `not one sentence: ${sentence}`);
    assert(await page.locator("#message").isVisible());
    assert(!(await page.locator("#progress").isVisible()), "the progress bar goes on");
    await screenshot(page, `${name.replaceAll(" ", "-")}.png`);
    await page.close();
  });
}

/** An iPad calls itself a Macintosh; only that it is touched tells it from one. */
async function checkTablet(browser, url) {
  const userAgent = "Mozilla/5.0 (Macintosh; Intel Mac OS X 10_15_7) AppleWebKit/605.1.15 Version/26.0 Safari/605.1.15";
  for (const [name, hasTouch] of [["an iPad is given a keyboard", true], ["a Macintosh keeps its own", false]]) {
    await check(name, async () => {
      const { page } = await openPage(browser, { userAgent, hasTouch });
      await page.goto(url);
      assert.equal(await page.evaluate(() => window.oculariumHost.isTelephone()), hasTouch);
      assert.equal(await page.evaluate(() => navigator.userAgent.includes("iPad")), hasTouch);
      await page.close();
    });
  }
}

/** The page in a browser whose screen has so many pixels a point. */
async function checkDensity(url, { ratio, sizes, touch }) {
  const [[width, height]] = sizes;
  const flags = [`--force-device-scale-factor=${ratio}`, `--window-size=${width},${height}`];
  const browser = await launch([...SOFTWARE_WEBGPU, ...flags]);
  const { page, complaints } = await openPage(browser, { viewport: null });
  if (touch) await becomeTelephone(page);
  // Under another light than the usual one: a ring flash is mirrored by a shader of its own, a scene by its own map.
  const light = touch ? "scene" : "ring";
  const link = `v=1&patient=healthy-blue&scene=chart&light=${light}`;
  await checkStart(page, `${url}#${link}`, `first live frame at ${ratio} pixels a point`);
  await check(`the link keeps its light at ${ratio} pixels a point`, async () => {
    assert.match(await page.evaluate(() => location.hash), new RegExp(`light=${light}`));
  });
  if (touch && tally.failed === 0) await checkTelephone(page);
  if (tally.failed === 0) await checkWindows(page, ratio, sizes);
  await check(`nothing is reported in the console at ${ratio} pixels a point`, () => assert.deepEqual(complaints, []));
  await browser.close();
}

async function main() {
  await mkdir(OUT, { recursive: true });
  await readFile(join(DIST, "index.html")).catch(() => {
    throw new Error("web/dist is not built: run ./dev web-build");
  });
  await checkComparators();

  const { server, url } = await serve(DIST, { base: "/any/sub-path/" });
  const browser = await launch(SOFTWARE_WEBGPU);
  report.browser = browser.version();
  const { page, complaints } = await openPage(browser, { permissions: ["clipboard-read", "clipboard-write"] });
  await page.addInitScript(SLEEPER);
  await page.addInitScript(DEVICES);
  await checkStart(page, url);
  if (tally.failed === 0) {
    await checkState(page);
    await checkPictures(page);
    // Leaves a smaller window, in which a software rasteriser is quicker.
    await checkControls(page);
    await checkConditions(page);
    await checkWalk(page);
    await checkOwn(page);
    await checkChoices(page);
    await checkSizes(page);
    await checkHiding(page);
    await checkDeviceLoss(page, complaints);
  }
  await check("nothing is reported in the console", () => assert.deepEqual(complaints, []));
  await page.context().close();

  await checkTablet(browser, url);
  for (const density of DENSITIES) await checkDensity(url, density);

  await checkSentence(browser, url, {
    name: "a browser without WebGPU gets a sentence",
    setUp: (fresh) => fresh.addInitScript(() => Object.defineProperty(navigator, "gpu", { value: undefined })),
    wanted: [/needs WebGPU/, /does not have/, /Chrome/, /Firefox/, /Safari/],
  });
  await checkSentence(browser, pathToFileURL(join(DIST, "index.html")).href, {
    name: "a page that is opened as a file gets a sentence",
    wanted: [/web server/, /dev web/],
  });
  await checkSentence(browser, url, {
    name: "a module that cannot be loaded gets a sentence",
    setUp: (fresh) => fresh.route("**/*.wasm*", (route) => route.fulfill({ status: 404, body: "" })),
    wanted: [/could not start/, /404/],
  });
  await browser.close();
  const plain = await launch([]);
  await checkSentence(plain, url, {
    name: "a browser without a graphics device gets a sentence",
    wanted: [/needs WebGPU/, /Chrome/, /Firefox/, /Safari/],
  });
  await plain.close();
  server.close();
}

try {
  await main();
} catch (error) {
  tally.failed += 1;
  console.log(`FAIL  ${error.message}`);
}
await writeFile(join(OUT, "report.json"), `${JSON.stringify({ ...report, ...tally }, null, 2)}\n`).catch(() => {});
console.log(`${tally.passed} passed, ${tally.failed} failed`);
process.exit(tally.failed === 0 ? 0 : 1);
