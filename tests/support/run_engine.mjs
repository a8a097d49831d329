// node run_engine.mjs ENGINE.js MODEL.wasm: reads a job from the standard input (an object literal, which may hold
// NaN) and prints what drive() found, as JSON.

import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";
import { drive } from "./drive_model.mjs";

const [engine, wasm] = process.argv.slice(2);
const { Engine, ModelError } = await import(pathToFileURL(engine));
const job = new Function(`return ${readFileSync(0, "utf8")}`)();
let results;
try {
  const model = await Engine.create(readFileSync(wasm), job.description, job.files, job.start);
  results = drive(model, job.commands, job.names);
} catch (error) {
  if (!(error instanceof ModelError)) throw error;
  results = [{ refused: error.message }];
}
process.stdout.write(JSON.stringify(results));
