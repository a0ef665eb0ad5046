// Loads web/dist in headless Chromium on software WebGPU and judges it as a visitor would: it starts,
// both panels show a moving picture, keys and resizing work, nothing is reported in the console, and
// where WebGPU is missing the page says so. `./dev web-test` builds the page, then runs this.
//
// Leaves screenshots and report.json in out/web. CHROMIUM names the browser.
import assert from "node:assert/strict";
import { accessSync, constants } from "node:fs";
import { mkdir, readFile, writeFile } from "node:fs/promises";
import { delimiter, join } from "node:path";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";
import { DIST, serve } from "../serve.mjs";
import * as pixels from "./pixels.mjs";

const OUT = fileURLToPath(new URL("../../out/web", import.meta.url));
const VIEWPORT = { width: 1280, height: 720 };
const READY_LIMIT_S = 90; // on two slow cores; the target on a usual machine is in docs/performance.md
const MOTION_LIMIT_S = 60; // an eye at rest may hold still for a while, and a frame may take seconds

// The only set of flags with which Chromium gives WebGPU to a machine without GPU and display.
const SOFTWARE_WEBGPU = [
  "--enable-unsafe-webgpu",
  "--ignore-gpu-blocklist",
  "--enable-features=Vulkan",
  "--use-vulkan=swiftshader",
  "--use-webgpu-adapter=swiftshader",
  "--use-angle=swiftshader",
  "--enable-unsafe-swiftshader",
];
const QUIET = [
  "--no-sandbox",
  "--no-first-run",
  "--disable-background-networking",
  "--disable-component-update",
  "--disable-sync",
  "--disable-quic",
];

// ---- A small harness ----------------------------------------------------------------------------

let passed = 0;
let failed = 0;
const report = {};

async function check(name, body) {
  try {
    await body();
    passed += 1;
    console.log(`ok    ${name}`);
  } catch (error) {
    failed += 1;
    console.log(`FAIL  ${name}: ${error.message}`);
  }
}

const pause = (milliseconds) => new Promise((resolve) => setTimeout(resolve, milliseconds));

/** Calls `attempt` until it returns something true; its last answer after `limit_s`. */
async function until(limit_s, attempt) {
  const end = Date.now() + 1000 * limit_s;
  for (;;) {
    const answer = await attempt();
    if (answer || Date.now() > end) return answer;
    await pause(250);
  }
}

function findBrowser() {
  const names = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];
  const places = names.flatMap((name) => process.env.PATH.split(delimiter).map((folder) => join(folder, name)));
  const found = [process.env.CHROMIUM, ...places].filter(Boolean).find((file) => {
    try {
      accessSync(file, constants.X_OK);
      return true;
    } catch {
      return false;
    }
  });
  if (!found) throw new Error("Chromium is missing: install it, or set CHROMIUM to its binary");
  return found;
}

const launch = (flags) => chromium.launch({ executablePath: findBrowser(), args: [...QUIET, ...flags] });

/** Opens a page and keeps everything that goes wrong on it, in words. */
async function openPage(browser) {
  const page = await browser.newPage({ viewport: VIEWPORT });
  await page.addInitScript(() => {
    // The app publishes its state a few times a second; counting that tells how far it has come.
    let state;
    window.publications = 0;
    Object.defineProperty(window, "oculariumState", {
      get: () => state,
      set(value) {
        state = value;
        window.publications += 1;
      },
    });
  });
  const complaints = [];
  page.on("console", (entry) => {
    // A shader or a pipeline that the browser refuses is only a warning of Chromium's.
    const refused = entry.type() === "warning" && /validation|WGSL|\[Invalid|device (was )?lost/i.test(entry.text());
    if (entry.type() === "error" || refused) complaints.push(`console: ${entry.text()}`);
  });
  page.on("pageerror", (error) => complaints.push(`page error: ${error.message}`));
  page.on("requestfailed", (request) => complaints.push(`not loaded: ${request.url()}`));
  page.on("response", (response) => {
    if (response.status() >= 400) complaints.push(`${response.status()}: ${response.url()}`);
  });
  return { page, complaints };
}

const readState = (page) => page.evaluate(() => JSON.parse(window.oculariumState));

/** Waits until the app has been through `count` more publications, so that it has seen all input. */
async function published(page, count) {
  const wanted = count + (await page.evaluate(() => window.publications));
  await page
    .waitForFunction((number) => window.publications >= number, wanted, { timeout: 1000 * MOTION_LIMIT_S, polling: 100 })
    .catch(() => {
      throw new Error(`the app published its state less than ${count} times in ${MOTION_LIMIT_S} s`);
    });
}

async function screenshot(page, name) {
  const bytes = await page.screenshot({ timeout: 60000 });
  if (name) await writeFile(join(OUT, name), bytes);
  return pixels.decode(bytes);
}

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

async function checkStart(page, url) {
  await check(`first live frame within ${READY_LIMIT_S} s`, async () => {
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
    report.first_live_frame_s = (Date.now() - start) / 1000;
    const message = await page.locator("#message").textContent();
    if (verdict !== "ready") await screenshot(page, "not-ready.png");
    assert.equal(verdict, "ready", `${verdict}, the page says: ${message}`);
    console.log(`      first live frame after ${report.first_live_frame_s.toFixed(1)} s`);
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

const PANELS = ["eye", "view"];

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

async function main() {
  await mkdir(OUT, { recursive: true });
  await readFile(join(DIST, "index.html")).catch(() => {
    throw new Error("web/dist is not built: run ./dev web-build");
  });
  await checkComparators();

  const { server, url } = await serve(DIST, { base: "/any/sub-path/" });
  const browser = await launch(SOFTWARE_WEBGPU);
  report.browser = browser.version();
  const { page, complaints } = await openPage(browser);
  await checkStart(page, url);
  if (failed === 0) {
    await checkState(page);
    await checkPictures(page);
    await checkControls(page);
  }
  await check("nothing is reported in the console", () => assert.deepEqual(complaints, []));
  await page.close();

  await checkSentence(browser, url, {
    name: "a browser without WebGPU gets a sentence",
    setUp: (fresh) => fresh.addInitScript(() => Object.defineProperty(navigator, "gpu", { value: undefined })),
    wanted: [/needs WebGPU/, /does not have/, /Chrome/, /Firefox/, /Safari/],
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
  failed += 1;
  console.log(`FAIL  ${error.message}`);
}
await writeFile(join(OUT, "report.json"), `${JSON.stringify({ ...report, passed, failed }, null, 2)}\n`).catch(() => {});
console.log(`${passed} passed, ${failed} failed`);
process.exit(failed === 0 ? 0 : 1);
