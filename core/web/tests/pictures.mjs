// Makes the pictures of the window and of the report that the README shows: of the built-in recording `street`, in host-sim/assets.
//
//   SMR_HOST_SIM=target/release/host-sim node core/web/tests/pictures.mjs

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

const folder = mkdtempSync(join(tmpdir(), "smr-pictures-"));
const browser = new Browser(["--hide-scrollbars"]);
const view = spawn(HOST_SIM, ["view", "street", "--no-open", "--json"]);

async function shoot(address, name, until) {
  const page = await browser.page(`${address}#frame=${FRAME}`, SIZE);
  await page.until(until);
  await new Promise((resolve) => setTimeout(resolve, 1000));
  const { data } = await page.call("Page.captureScreenshot", { format: "jpeg", quality: 60 });
  writeFileSync(join(PROJECT, "host-sim/assets", name), Buffer.from(data, "base64"));
  await page.close();
}

try {
  const line = await new Promise((resolve) => view.stdout.once("data", resolve));
  await shoot(JSON.parse(line).address, "window.jpg", `!document.body.textContent.includes("Following:") && document.getElementById("place").value.includes("${FRAME}")`);
  const report = join(folder, "report.html");
  spawnSync(HOST_SIM, ["report", "street", "-o", report]);
  await shoot(pathToFileURL(report).href, "report.jpg", `document.getElementById("place").value.includes("${FRAME}")`);
} finally {
  view.kill("SIGINT");
  await browser.close();
  rmSync(folder, { recursive: true });
}
