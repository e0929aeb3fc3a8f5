// Entry of the stand-alone page: the application, with frames that the browser itself decodes.

import { run } from "./application.js";
import { byId } from "./dom.js";
import { read } from "./files.js";
import { Local } from "./local.js";

const source = new Local();
run(source, {
  camera: () => source.camera(),
  "built-in": () => source.builtIn(),
  file: async () => {
    const [file] = byId("file").files;
    // Clears the field, so that the same file can be chosen again.
    byId("file").value = "";
    await read(file);
  },
});
