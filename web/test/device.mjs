// A tab that is hidden for long, and a graphics device that goes away.
import assert from "node:assert/strict";
import { check, MOTION_LIMIT_S, published, READY_LIMIT_S, readState, until } from "./harness.mjs";

/** Lets a test put the page to sleep: no frames come while its clock goes on, as in a hidden tab. */
export const SLEEPER = () => {
  const frame = window.requestAnimationFrame.bind(window);
  const now = performance.now.bind(performance);
  let skew = 0;
  let asleep = false;
  let waiting = [];
  window.requestAnimationFrame = (callback) => {
    if (!asleep) return frame((time) => callback(time + skew));
    waiting.push(callback);
    return 0;
  };
  performance.now = () => now() + skew;
  window.hideFor = async (seconds) => {
    asleep = true;
    // A frame that is being drawn may take seconds.
    const pause = () => new Promise((resolve) => setTimeout(resolve, 250));
    for (let tries = 0; waiting.length === 0 && tries < 120; tries += 1) await pause();
    await pause();
    skew += 1000 * seconds;
    asleep = false;
    const woken = waiting;
    waiting = [];
    for (const callback of woken) frame((time) => callback(time + skew));
    return woken.length;
  };
};

export async function checkHiding(page) {
  await check("ten minutes in a hidden tab are no ten minutes of the eye's life", async () => {
    const before = await readState(page);
    const start = Date.now();
    const held = await page.evaluate(() => window.hideFor(600));
    assert(held > 0, "no frame was waiting, so nothing was hidden");
    await published(page, 3);
    const after = await readState(page);
    const passed = (Date.now() - start) / 1000;
    assert(after.time_s > before.time_s, "the clock stands still");
    assert(after.time_s - before.time_s < passed + 1, `${after.time_s - before.time_s} s went by in ${passed} s`);
    // An eye that looks about makes three or four fixations a second, and never one a frame.
    const fixations = after.fixations - before.fixations;
    assert(fixations <= 5 * (passed + 1), `${fixations} fixations in ${passed} s`);
  });
}

export async function checkDeviceLoss(page, complaints) {
  await check("a lost graphics device gets a sentence, and the page comes back as it was", async () => {
    await page.evaluate(() => {
      location.hash = "v=1&patient=glaucoma-moderate&redness=0.7&scene=chart&seed=5";
    });
    const set = await until(MOTION_LIMIT_S, async () => {
      const { patient, scene, seed } = await readState(page);
      return patient === "Glaucoma, moderate" && scene === "chart" && seed === "5";
    });
    assert(set, "the link was not obeyed");
    const link = await until(10, async () => {
      const hash = await page.evaluate(() => location.hash);
      return /glaucoma-moderate.*redness=0\.7/.test(hash) && hash;
    });
    assert(link, "the link is not there");
    const before = complaints.length;
    await page.evaluate(() => window.devices.at(-1).destroy());
    await page.waitForSelector("[data-lost] #message", { timeout: 30000 });
    const sentence = await page.locator("#message").textContent();
    assert.match(sentence, /graphics device was lost.*loads again.*come back/);
    await page.waitForFunction(() => window.oculariumReady === true && !("lost" in document.documentElement.dataset), null, {
      timeout: 1000 * READY_LIMIT_S,
      polling: 200,
    });
    const { patient, scene, seed } = await readState(page);
    assert.deepEqual({ patient, scene, seed }, { patient: "Glaucoma, moderate", scene: "chart", seed: "5" });
    assert.match(await page.evaluate(() => location.hash), /redness=0\.7/);
    // What the browser says about its own loss is no fault of the page's.
    complaints.splice(before);
  });
}

/** Keeps the devices that the page gets, so that a test can take them away. */
export const DEVICES = () => {
  window.devices = [];
  if (!window.GPUAdapter) return;
  const request = GPUAdapter.prototype.requestDevice;
  GPUAdapter.prototype.requestDevice = async function requestDevice(...wanted) {
    const device = await request.apply(this, wanted);
    window.devices.push(device);
    return device;
  };
};
