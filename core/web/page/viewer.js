// Entry of the page of `host-sim view`.

import { run } from "./application.js";
import { Connection } from "./connection.js";

run(new Connection());
