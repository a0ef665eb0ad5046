// What one person's state does to both panels: a head that walks, a condition that begins and worsens.
import assert from "node:assert/strict";
import { check, MOTION_LIMIT_S, PANELS, pauseWithOpenLids, published, readState, screenshot, setPaused, until } from "./harness.mjs";
import * as pixels from "./pixels.mjs";

/** Both panels at the next moment, cut out of a screenshot. */
async function panels(page, name) {
  await published(page, 2);
  const { panels: places } = await readState(page);
  const whole = await screenshot(page, name);
  return Object.fromEntries(PANELS.map((panel) => [panel, pixels.crop(whole, places[panel])]));
}

const changes = (a, b) => Object.fromEntries(PANELS.map((panel) => [panel, pixels.changedFraction(a[panel], b[panel])]));

/** The share of the middle of the eye's panel, where the pupil is, that is as red as no iris. */
function redShare({ eye }) {
  // A wide pupil and what is next to it: lid margins are red by themselves.
  const { data } = pixels.crop(eye, [0.4 * eye.width, 0.4 * eye.height, 0.2 * eye.width, 0.2 * eye.height]);
  let red = 0;
  for (let at = 0; at < data.length; at += 4) red += data[at] > 70 && data[at] > 1.65 * data[at + 1];
  return red / (data.length / 4);
}

/** While time stands still only what is done here changes a picture. */
export async function checkWalk(page) {
  await pauseWithOpenLids(page);
  const before = await panels(page, "before-walking.png");
  await check("nothing moves while time stands still", async () => {
    const { eye, view } = changes(before, await panels(page));
    assert(eye < pixels.CHANGED_FRACTION && view < pixels.CHANGED_FRACTION, `${eye} of the eye, ${view} of the view`);
  });
  await check("the keys walk, and the view goes with the head", async () => {
    const from = (await readState(page)).head;
    await page.keyboard.down("w");
    const walked = await until(MOTION_LIMIT_S, async () => (await readState(page)).head[2] > from[2] + 0.3);
    await page.keyboard.up("w");
    assert(walked, `the head is at ${(await readState(page)).head}`);
    const { view } = changes(before, await panels(page, "walked.png"));
    assert(view > 0.2, `${view} of the view has changed`);
  });
  await check("the arrow keys turn the head", async () => {
    const from = (await readState(page)).head;
    await page.keyboard.down("ArrowRight");
    const turned = await until(MOTION_LIMIT_S, async () => (await readState(page)).head[3] > from[3] + 5);
    await page.keyboard.up("ArrowRight");
    assert(turned, `the head is at ${(await readState(page)).head}`);
  });
  // The head goes back to its place.
  await page.keyboard.press("r");
  await setPaused(page, false);
}

/** An artist's choices are drawn, by a pipeline of their own, and an astigmat's view by another. */
export async function checkChoices(page) {
  await pauseWithOpenLids(page);
  const shown = async (link, name) => {
    await page.evaluate((hash) => (location.hash = hash), `v=1&scene=room&seed=1&${link}`);
    const there = await until(MOTION_LIMIT_S, async () => {
      const state = await readState(page);
      return state.patient === "Healthy, blue" && state.scene === "room";
    });
    assert(there, "the patient is not there");
    await published(page, 6);
    return panels(page, name);
  };
  await check("an artist's choice shows in the eye", async () => {
    const plain = await shown("patient=healthy-blue");
    await shown("patient=healthy-blue&look_iris_brightness=3.5&look_refraction=0", "artist.png");
    const bright = await until(MOTION_LIMIT_S, async () => changes(plain, await panels(page, "artist.png")).eye > 0.005);
    assert(bright, "the eye stays as it was");
  });
  await check("the fundus shines red before a light along the lens's axis", async () => {
    const before = redShare(await shown("patient=healthy-blue&light=window&pupil_mm=7"));
    assert(before < 0.02, `${before} is red already`);
    await shown("patient=healthy-blue&light=coaxial&pupil_mm=7", "coaxial.png");
    let red = 0;
    const reflex = await until(MOTION_LIMIT_S, async () => {
      red = redShare(await panels(page, "coaxial.png"));
      return red > before + 0.03;
    });
    assert(reflex, `${red} of the middle is red, by a window ${before}`);
  });
  await setPaused(page, false);
  await check("an astigmat's view is drawn", async () => {
    await page.evaluate(() => (location.hash = "v=1&scene=room&seed=1&patient=astigmat&cylinder_d=-6"));
    assert(await until(MOTION_LIMIT_S, async () => /Astigmat/.test((await readState(page)).patient)), "she is not there");
    await published(page, 6);
    const { view } = await panels(page, "astigmat.png");
    assert(pixels.isLitPicture(view), "the view is dark");
  });
  // Elongated blur costs a software rasteriser twice the time: what follows goes on with somebody without it.
  await page.evaluate(() => (location.hash = "v=1&scene=room&seed=1&patient=healthy-blue"));
  await until(MOTION_LIMIT_S, async () => /Healthy/.test((await readState(page)).patient));
}

/** Scrolls the controls until one of them is in reach, and says where its middle is. */
async function reach(page, name) {
  const inReach = async () => {
    const { places } = await readState(page);
    if (!places[name]) return null;
    const [x, y, w, h] = places[name];
    const { height } = page.viewportSize();
    if (y > 40 && y + h < height - 20) {
      // A section opens in steps: a place that is still moving is none.
      await published(page, 2);
      const [nowX, nowY] = (await readState(page)).places[name] ?? [];
      return Math.hypot(nowX - x, nowY - y) < 1 ? [x + w / 2, y + h / 2, w] : null;
    }
    await page.mouse.move(x + w / 2, height / 2);
    await page.mouse.wheel(0, y < 40 ? -150 : 150);
    await published(page, 2);
    return null;
  };
  const place = await until(MOTION_LIMIT_S, inReach);
  assert(place, `the control ${name} is not in reach`);
  return place;
}

export async function checkConditions(page) {
  await pauseWithOpenLids(page);
  const healthy = await panels(page, "without-cataract.png");
  await check("a cataract begins by its control, and both panels show it", async () => {
    const [x, y] = await reach(page, "anatomy");
    await page.mouse.click(x, y);
    const [toggleX, toggleY] = await reach(page, "cataract");
    await page.mouse.click(toggleX, toggleY);
    const written = await until(MOTION_LIMIT_S, () => page.evaluate(() => /cataract=\([^)]*nuclear:2\.5/.test(location.hash)));
    assert(written, `the link is ${await page.evaluate(() => location.hash)}`);
    const seen = await until(MOTION_LIMIT_S, async () => changes(healthy, await panels(page, "cataract.png")).view > 0.3);
    assert(seen, "the view is as it was");
  });
  await check("its slider makes it worse", async () => {
    const before = await panels(page);
    const [x, y, w] = await reach(page, "nuclear");
    // A slider's own part is the left of its row.
    await page.mouse.move(x - 0.4 * w, y);
    await page.mouse.down();
    await published(page, 1);
    await page.mouse.move(x - 0.12 * w, y, { steps: 4 });
    await published(page, 1);
    await page.mouse.up();
    const grade = async () => Number(/nuclear:([0-9.]+)/.exec(await page.evaluate(() => location.hash))?.[1] ?? 0);
    assert(await until(MOTION_LIMIT_S, async () => (await grade()) > 3), `the grade is ${await grade()}`);
    const { view, eye } = changes(before, await panels(page, "worse-cataract.png"));
    assert(view > 0.3, `${view} of the view has changed`);
    assert(eye > pixels.CHANGED_FRACTION, `${eye} of the eye has changed`);
  });
  await check("without it both panels are as they were", async () => {
    const [x, y] = await reach(page, "cataract");
    await page.mouse.click(x, y);
    const back = await until(MOTION_LIMIT_S, async () => {
      const { eye, view } = changes(healthy, await panels(page, "cataract-gone.png"));
      return eye < 0.005 && view < 0.005;
    });
    assert(back, "a panel keeps something of it");
  });
  const [x, y] = await reach(page, "anatomy");
  await page.mouse.click(x, y);
  await setPaused(page, false);
}
