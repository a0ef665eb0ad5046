// A visitor's own files, the link, and what can be taken away: nothing leaves the browser.
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { fileURLToPath } from "node:url";
import { check, MOTION_LIMIT_S, published, readState, screenshot, setPaused, until, VIEWPORT } from "./harness.mjs";
import * as pixels from "./pixels.mjs";

const PAGE_PNG = fileURLToPath(new URL("../../tests/data/page.png", import.meta.url));
const DEPTH = fileURLToPath(new URL("../../tests/data/depth", import.meta.url));
const THREE_SECONDS = fileURLToPath(new URL("../../tests/data/three_seconds.gif", import.meta.url));
const ANN = '(name: "Ann", description: "Made for a test.", age_years: 44, sphere_d: -2.5, iris_color: Green)';

const fragment = (page) => page.evaluate(() => location.hash);

/** Waits until the published state is as wanted. */
async function becomes(page, what, wanted) {
  const met = await until(MOTION_LIMIT_S, async () => wanted(await readState(page)));
  if (!met) {
    const { patient, scene, seed, sphere_d: sphere, message } = await readState(page);
    assert.fail(`${what}: ${JSON.stringify({ patient, scene, seed, sphere, message })}, link ${await fragment(page)}`);
  }
}

const middle = ([x, y, w, h]) => [x + w / 2, y + h / 2];

async function press(page, name) {
  const { places } = await readState(page);
  assert(places[name], `there is no control ${name} among ${Object.keys(places)}`);
  await page.mouse.click(...middle(places[name]));
}

/** Drops files on the page, as `[name, base64]`. */
const drop = (page, files) =>
  page.evaluate(async (list) => {
    const data = new DataTransfer();
    for (const [name, base64] of list) {
      const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
      data.items.add(new File([bytes], name));
    }
    const event = (type) => new DragEvent(type, { dataTransfer: data, bubbles: true, cancelable: true });
    const target = document.getElementById("ocularium");
    target.dispatchEvent(event("dragenter"));
    window.dropShown = getComputedStyle(document.getElementById("drop")).display;
    target.dispatchEvent(event("drop"));
  }, files);

async function checkLink(page) {
  await check("the link says what is shown", async () => {
    const written = await until(10, async () => (await fragment(page)).includes("patient="));
    assert(written, `the link is ${await fragment(page)}`);
    assert.match(await fragment(page), /^#v=1&patient=healthy-brown&scene=room&seed=1/);
  });
  await check("a link that is put in its place is obeyed without loading the page again", async () => {
    const publications = await page.evaluate(() => window.publications);
    await page.evaluate(() => {
      location.hash = "v=1&patient=myope-3d&sphere_d=-5&scene=chart&seed=18446744073709551615&orbit=30,-5,120";
    });
    await becomes(page, "the link's state", (s) => s.patient === "Myope, -3 D" && s.sphere_d === -5 && s.scene === "chart");
    const state = await readState(page);
    assert.equal(state.seed, "18446744073709551615");
    assert.deepEqual(state.orbit, [30, -5, 120]);
    assert((await page.evaluate(() => window.publications)) > publications, "the page was loaded again");
  });
  await check("what a link asks for in vain is said, and the rest is shown", async () => {
    await page.evaluate(() => {
      location.hash = "v=1&patient=nobody&scene=room&seed=3";
    });
    await becomes(page, "a sentence about the patient", (s) => /"nobody".*healthy-brown/.test(s.message ?? ""));
    await becomes(page, "the rest of it", (s) => s.scene === "room" && s.seed === "3");
    const rewritten = await until(10, async () => /patient=healthy-brown/.test(await fragment(page)));
    assert(rewritten, `the link stays ${await fragment(page)}`);
  });
  await check("a change is written into the link within seconds", async () => {
    await page.keyboard.press("m");
    const written = await until(20, async () => (await fragment(page)).includes("marker=on"));
    assert(written, `the link is ${await fragment(page)}`);
    await page.keyboard.press("m");
  });
}

/** Means of the view's channels. */
async function viewMeans(page, name) {
  const { panels } = await readState(page);
  const { data } = pixels.crop(await screenshot(page, name), panels.view);
  const sums = [0, 0, 0];
  for (let i = 0; i < data.length; i += 4) sums.forEach((sum, k) => (sums[k] = sum + data[i + k]));
  return sums.map((sum) => (4 * sum) / data.length);
}

/** A model of a red triangle that is on the left for two seconds and on the right for two. */
function leapingTriangle() {
  const floats = [-0.4, -0.4, 0, 0.4, -0.4, 0, 0, 0.4, 0, 0, 2, 4, -0.8, 0, -3, 0.8, 0, -3, -0.8, 0, -3];
  const accessor = (bufferView, count, type, min, max) => ({ bufferView, componentType: 5126, count, type, min, max });
  return {
    asset: { version: "2.0" },
    extensionsUsed: ["KHR_materials_unlit"],
    scenes: [{ nodes: [0, 1] }],
    nodes: [{ mesh: 0 }, { camera: 0 }],
    cameras: [{ type: "perspective", perspective: { yfov: 0.9, znear: 0.1 } }],
    materials: [{ extensions: { KHR_materials_unlit: {} }, pbrMetallicRoughness: { baseColorFactor: [1, 0, 0, 1] } }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, material: 0 }] }],
    animations: [
      {
        samplers: [{ input: 1, output: 2, interpolation: "STEP" }],
        channels: [{ sampler: 0, target: { node: 0, path: "translation" } }],
      },
    ],
    buffers: [
      {
        byteLength: 4 * floats.length,
        uri: `data:application/octet-stream;base64,${Buffer.from(new Float32Array(floats).buffer).toString("base64")}`,
      },
    ],
    bufferViews: [
      { buffer: 0, byteLength: 36 },
      { buffer: 0, byteOffset: 36, byteLength: 12 },
      { buffer: 0, byteOffset: 48, byteLength: 36 },
    ],
    accessors: [
      accessor(0, 3, "VEC3", [-0.4, -0.4, 0], [0.4, 0.4, 0]),
      accessor(1, 3, "SCALAR", [0], [4]),
      accessor(2, 3, "VEC3", [-0.8, 0, -3], [0.8, 0, -3]),
    ],
  };
}

async function checkFiles(page) {
  await check("a patient file is opened by the button", async () => {
    // A browser opens no chooser for a press that it answers too late: on a slow machine, one that comes while another is loaded.
    await published(page, 3);
    const chooser = page.waitForEvent("filechooser", { timeout: 20000 });
    await press(page, "open");
    await (await chooser).setFiles([{ name: "ann.ron", mimeType: "text/plain", buffer: Buffer.from(ANN) }]);
    await becomes(page, "Ann", (s) => s.patient === "Ann" && s.sphere_d === -2.5);
    const written = await until(10, async () => /name=Ann.*|sphere_d=-2\.5/.test(await fragment(page)));
    assert(written, `the link is ${await fragment(page)}`);
  });
  await check("a photograph is shown when it is dropped", async () => {
    const photo = (await readFile(PAGE_PNG)).toString("base64");
    await drop(page, [["page.png", photo]]);
    assert.equal(await page.evaluate(() => window.dropShown), "grid", "the page does not say where to drop");
    await becomes(page, "the photograph", (s) => s.scene === "page.png");
    const bright = await until(MOTION_LIMIT_S, async () => {
      const { panels } = await readState(page);
      return pixels.brightness(pixels.crop(await screenshot(page, "own-photograph.png"), panels.view)).mean > 150;
    });
    assert(bright, "the view is not that of a white page");
  });
  await check("a photograph's sliders begin where it stands and move it when they are let go", async () => {
    // Its width at 3 m and 50°, as photographs stand that say nothing else.
    const { photograph, places } = await readState(page);
    assert.deepEqual(photograph, [3, 50]);
    for (const [name, index] of [["away", 0], ["high", 1]]) {
      const [x, y, w, h] = places[name];
      const before = (await readState(page)).photograph;
      await page.mouse.move(x + 0.2 * w, y + h / 2);
      await page.mouse.down();
      await published(page, 2);
      await page.mouse.move(x + 0.1 * w, y + h / 2, { steps: 3 });
      await published(page, 2);
      assert.deepEqual((await readState(page)).photograph, before, "it moved before it was let go");
      await page.mouse.up();
      await becomes(page, `the slider ${name}`, (s) => s.photograph[index] < 0.5 * before[index]);
      const after = (await readState(page)).photograph;
      assert.equal(after[1 - index], before[1 - index], "the other slider's value went with it");
    }
  });
  await check("a photograph's depth image is read as the visitor says", async () => {
    const base64 = async (name) => (await readFile(`${DEPTH}/${name}`)).toString("base64");
    await drop(page, [["checks.png", await base64("checks.png")], ["depth.png", await base64("millimetres_16.png")]]);
    const middle = (metres) => (s) => Math.abs(s.photograph?.[0] / metres - 1) < 1e-3;
    await becomes(page, "millimetres, as found", (s) => s.scene === "checks.png" && middle(3)(s));
    await published(page, 2);
    await press(page, "inverse");
    // Code 3000 of 65535, white at 0.5 m and black infinitely far.
    await becomes(page, "inverse", middle((0.5 * 65535) / 3000));
    await published(page, 2);
    const [x, y, w, h] = (await readState(page)).places.white;
    await page.mouse.move(x + 0.2 * w, y + h / 2);
    await page.mouse.down();
    await published(page, 2);
    await page.mouse.move(x + 0.05 * w, y + h / 2, { steps: 3 });
    await published(page, 2);
    await page.mouse.up();
    await becomes(page, "white nearer", (s) => s.photograph[0] < (0.3 * 65535) / 3000);
  });
  await check("pictures that follow one another are seen one after the other", async () => {
    const gif = (await readFile(THREE_SECONDS)).toString("base64");
    await drop(page, [["three_seconds.gif", gif]]);
    await becomes(page, "the pictures", (s) => s.scene === "three_seconds.gif");
    // Red, green, blue. Time stands still while a picture is looked at: a slow browser's next one comes before it is drawn.
    for (const [picture, name, channel, other] of [[0, "red", 0, 2], [2, "blue", 2, 0]]) {
      const stands = await until(MOTION_LIMIT_S, async () => {
        if ((await readState(page)).picture !== picture) return false;
        await setPaused(page, true);
        if ((await readState(page)).picture === picture) return true;
        await setPaused(page, false);
        return false;
      });
      assert(stands, `there was never the ${name} one`);
      let means = [];
      const seen = await until(MOTION_LIMIT_S, async () => {
        means = await viewMeans(page, `pictures-${name}.png`);
        return means[channel] > 1.5 * means[other];
      });
      assert(seen, `the ${name} one is seen as ${means}`);
      await setPaused(page, false);
    }
  });
  await check("a model's own animation is played", async () => {
    await drop(page, [["leap.gltf", Buffer.from(JSON.stringify(leapingTriangle())).toString("base64")]]);
    await becomes(page, "the model", (s) => s.scene === "leap.gltf");
    for (const [name, side] of [["left", -1], ["right", 1]]) {
      const seen = await until(MOTION_LIMIT_S, async () => {
        const { panels } = await readState(page);
        const view = pixels.crop(await screenshot(page, `leap-${name}.png`), panels.view);
        const middle = pixels.middleOf(view, ([r, g]) => r > 2 * g && r > 40);
        return middle !== null && side * (middle - 0.5) > 0.1;
      });
      assert(seen, `it was never on the ${name}`);
    }
  });
  await check("a model is shown with the buffer that is dropped beside it", async () => {
    const corners = Buffer.from(new Float32Array([-1, -1, -2, 1, -1, -2, 0, 1, -2]).buffer).toString("base64");
    const model = {
      asset: { version: "2.0" },
      scenes: [{ nodes: [0] }],
      nodes: [{ mesh: 0 }],
      meshes: [{ primitives: [{ attributes: { POSITION: 0 } }] }],
      buffers: [{ byteLength: 36, uri: "tri.bin" }],
      bufferViews: [{ buffer: 0, byteLength: 36 }],
      accessors: [{ bufferView: 0, componentType: 5126, count: 3, type: "VEC3", min: [-1, -1, -2], max: [1, 1, -2] }],
    };
    const text = Buffer.from(JSON.stringify(model)).toString("base64");
    await drop(page, [["tri.gltf", text]]);
    await becomes(page, "a sentence about the buffer", (s) => /tri\.bin.*together/.test(s.message ?? ""));
    await drop(page, [["tri.bin", corners], ["tri.gltf", text]]);
    await becomes(page, "the model", (s) => s.scene === "tri.gltf" && Math.abs(s.model_width_m - 2) < 1e-6);
  });
  await check("a model's unit is chosen, and is gone with the model", async () => {
    await published(page, 2);
    await press(page, "unit cm");
    await becomes(page, "centimetres", (s) => s.scene === "tri.gltf" && Math.abs(s.model_width_m - 0.02) < 1e-6);
    await page.evaluate(() => {
      location.hash = "v=1&patient=healthy-blue&scene=chart";
    });
    await becomes(page, "the chart", (s) => s.scene === "chart");
    await published(page, 2);
    assert.equal((await readState(page)).places["unit cm"], undefined, "a built-in scene has a unit to choose");
  });
  await check("a file that is nothing of these gets a sentence, and nothing is lost", async () => {
    await drop(page, [["notes.bin", Buffer.from([0, 159, 1, 2]).toString("base64")]]);
    await becomes(page, "a sentence", (s) => /notes\.bin.*neither a picture/.test(s.message ?? ""));
    assert.equal((await readState(page)).scene, "chart");
  });
}

async function checkTakingAway(page) {
  await check("what is seen is saved as PNG", async () => {
    const download = page.waitForEvent("download", { timeout: 60000 });
    await press(page, "save both");
    const file = await download;
    assert.equal(file.suggestedFilename(), "ocularium.png");
    const image = pixels.decode(await readFile(await file.path()));
    const { panels } = await readState(page);
    assert.equal(image.width, Math.round(panels.eye[2]) + Math.round(panels.view[2]));
    assert.equal(image.height, Math.round(panels.eye[3]));
    // The left half is the eye that is on the screen: no other picture has its brightness and contrast.
    const eye = pixels.crop(image, [0, 0, Math.round(panels.eye[2]), image.height]);
    assert(pixels.isLitPicture(eye), "the eye is dark or uniform");
  });
  await check("the link is copied", async () => {
    await press(page, "copy");
    await becomes(page, "a word about it", (s) => /copied/.test(s.notice ?? ""));
    const copied = await page.evaluate(() => navigator.clipboard.readText());
    assert.match(copied, /^http:\/\/[^#]*#v=1&patient=/);
  });
}

export async function checkOwn(page) {
  const requests = [];
  page.on("request", (request) => {
    if (!request.url().startsWith("blob:")) requests.push(request.url());
  });
  await page.setViewportSize(VIEWPORT);
  await published(page, 2);
  await checkLink(page);
  await checkFiles(page);
  await checkTakingAway(page);
  await check("nothing was sent anywhere", () => assert.deepEqual(requests, []));
}
