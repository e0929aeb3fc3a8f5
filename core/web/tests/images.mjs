// Creates the images of the README in host-sim/assets: frames, the viewer and the report of the recording `street`.
//
//   SMR_HOST_SIM=target/release/host-sim node core/web/tests/images.mjs

import { spawn, spawnSync } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { Browser } from "./browser.mjs";
import { PROJECT } from "./library.mjs";

const HOST_SIM = process.env.SMR_HOST_SIM;
const FRAME = 176;
const SIZE = { width: 1120, height: 640 };
// Frames of the first image: the car is in front of a tree, behind it, beside another car, and near.
const FRAMES = [20, 75, 187, 260];

const folder = mkdtempSync(join(tmpdir(), "smr-pictures-"));
const browser = new Browser(["--hide-scrollbars"]);
const view = spawn(HOST_SIM, ["view", "street", "--no-open", "--json"]);

const write = (name, data) => writeFileSync(join(PROJECT, "host-sim/assets", name), Buffer.from(data, "base64"));

async function shoot(address, name, until) {
  const page = await browser.page(`${address}#frame=${FRAME}`, SIZE);
  await page.until(until);
  await new Promise((resolve) => setTimeout(resolve, 1000));
  const { data } = await page.call("Page.captureScreenshot", { format: "jpeg", quality: 60 });
  write(name, data);
  return page;
}

/** Script that joins the report's images of the frames in `FRAMES` into one image, with two in each row. */
const strip = `(async () => {
  const stage = document.getElementById("stage");
  const strip = document.createElement("canvas");
  [strip.width, strip.height] = [2 * stage.width, ${FRAMES.length / 2} * stage.height];
  for (const [at, frame] of ${JSON.stringify(FRAMES)}.entries()) {
    location.hash = "frame=" + frame;
    while (stage.dataset.frame !== String(frame)) await new Promise((resolve) => setTimeout(resolve, 50));
    strip.getContext("2d").drawImage(stage, (at % 2) * stage.width, Math.floor(at / 2) * stage.height);
  }
  return strip.toDataURL("image/jpeg", 0.7).split(",")[1];
})()`;

try {
  const line = await new Promise((resolve) => view.stdout.once("data", resolve));
  await shoot(JSON.parse(line).address, "viewer.jpg", `!document.body.textContent.includes("Following:") && document.getElementById("place").value.includes("${FRAME}")`);
  const report = join(folder, "report.html");
  spawnSync(HOST_SIM, ["report", "street", "-o", report]);
  const page = await shoot(pathToFileURL(report).href, "report.jpg", `document.getElementById("place").value.includes("${FRAME}")`);
  write("street.jpg", await page.value(strip));
} finally {
  view.kill("SIGINT");
  await browser.close();
  rmSync(folder, { recursive: true });
}
