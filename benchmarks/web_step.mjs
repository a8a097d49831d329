// node web_step.mjs ENGINE.js MODEL.wasm: reads the job of web_step.py and prints the times of its blocks as JSON.

import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [engine, wasm] = process.argv.slice(2);
const { Engine } = await import(pathToFileURL(engine));
const { description, scenes, step, torque, rounds, angles } = JSON.parse(readFileSync(0, "utf8"));

/** Seconds of `work`. */
function seconds(work) {
  const start = performance.now();
  work();
  return (performance.now() - start) / 1000;
}

const blocks = {};
for (const [name, start] of Object.entries(scenes)) {
  const model = await Engine.create(readFileSync(wasm), description, {}, start);
  const run = () => {
    for (const tau of torque) {
      model.set("tau", tau);
      model.step(step);
    }
  };
  blocks[`${name}: torque and step`] = [torque.length, run];
  blocks[`${name}: another radius`] = [100, () => {
    for (let k = 0; k < 100; k++) model.set("cam1.radius", 0.02 + 1e-6 * (k % 2));
  }];
  blocks[`${name}: an angle of the stick band`] = [angles.length, () => model.band(angles)];
}

const times = Object.fromEntries(Object.keys(blocks).map((name) => [name, []]));
for (let round = -1; round < rounds; round++) {
  for (const [name, [count, work]] of Object.entries(blocks)) {
    const time = seconds(work) / count;
    if (round >= 0) times[name].push(time);
  }
}
process.stdout.write(JSON.stringify({ times, v8: process.versions.v8 }));
