// What the browser tests share: the browser, its page, and how checks are counted.
import assert from "node:assert/strict";
import { accessSync, constants } from "node:fs";
import { writeFile } from "node:fs/promises";
import { delimiter, join } from "node:path";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";
import * as pixels from "./pixels.mjs";

export const OUT = fileURLToPath(new URL("../../out/web", import.meta.url));
export const VIEWPORT = { width: 1280, height: 720 };
export const READY_LIMIT_S = 90; // on two slow cores; the target on a usual machine is in docs/performance.md
export const MOTION_LIMIT_S = 60; // an eye at rest may hold still for a while, and a frame may take seconds
export const PANELS = ["eye", "view"];

// The only set of flags with which Chromium gives WebGPU to a machine without GPU and display.
export const SOFTWARE_WEBGPU = [
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

export const tally = { passed: 0, failed: 0 };
export const report = {};

export async function check(name, body) {
  const start = Date.now();
  const seconds = () => ((Date.now() - start) / 1000).toFixed(1).padStart(6);
  try {
    await body();
    tally.passed += 1;
    console.log(`ok   ${seconds()} s  ${name}`);
  } catch (error) {
    tally.failed += 1;
    console.log(`FAIL ${seconds()} s  ${name}: ${error.message}`);
  }
}

export const pause = (milliseconds) => new Promise((resolve) => setTimeout(resolve, milliseconds));

/** Calls `attempt` until it returns something true; its last answer after `limit_s`. */
export async function until(limit_s, attempt) {
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

export const launch = (flags) => chromium.launch({ executablePath: findBrowser(), args: [...QUIET, ...flags] });

/** Opens a page and keeps everything that goes wrong on it, in words. */
export async function openPage(browser, options = {}) {
  const context = await browser.newContext({ viewport: VIEWPORT, ...options });
  const page = await context.newPage();
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
    // While the browser scrolls to a field that is touched, it remarks that its own events cannot be cancelled.
    const remark = /Ignored attempt to cancel a touchstart/.test(entry.text());
    if ((entry.type() === "error" && !remark) || refused) complaints.push(`console: ${entry.text()}`);
  });
  page.on("pageerror", (error) => complaints.push(`page error: ${error.message}`));
  page.on("requestfailed", (request) => complaints.push(`not loaded: ${request.url()}`));
  page.on("response", (response) => {
    if (response.status() >= 400) complaints.push(`${response.status()}: ${response.url()}`);
  });
  return { page, complaints };
}

export const readState = (page) => page.evaluate(() => JSON.parse(window.oculariumState));

/** Waits until the app has been through `count` more publications, so that it has seen all input. */
export async function published(page, count) {
  const wanted = count + (await page.evaluate(() => window.publications));
  await page
    .waitForFunction((number) => window.publications >= number, wanted, { timeout: 1000 * MOTION_LIMIT_S, polling: 100 })
    .catch(() => {
      throw new Error(`the app published its state less than ${count} times in ${MOTION_LIMIT_S} s`);
    });
}

/** Lets time stand still, or go on. */
export async function setPaused(page, wanted) {
  if ((await readState(page)).paused !== wanted) await page.keyboard.press("Space");
  assert(await until(MOTION_LIMIT_S, async () => (await readState(page)).paused === wanted), `paused is not ${wanted}`);
}

/** Lets time stand still while the lids are open: behind closed ones a view is black whatever its eye has. */
export async function pauseWithOpenLids(page) {
  const open = async () => {
    await setPaused(page, true);
    if ((await readState(page)).lid_aperture > 0.99) return true;
    await setPaused(page, false);
    return false;
  };
  assert(await until(MOTION_LIMIT_S, open), "the lids do not open");
}

/** A picture of the page, for which Chromium waits for a few of its frames: at 4K a software rasteriser is slow. */
export async function screenshot(page, name) {
  const bytes = await page.screenshot({ timeout: 1000 * READY_LIMIT_S });
  if (name) await writeFile(join(OUT, name), bytes);
  return pixels.decode(bytes);
}

