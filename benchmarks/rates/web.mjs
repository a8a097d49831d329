// node web.mjs ENGINE.js MODEL.wasm: reads the job of web.py and prints the times of its blocks as JSON.

import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [engine, wasm] = process.argv.slice(2);
const { Engine } = await import(pathToFileURL(engine));
const { description, scenes, step, torque, rounds, angles } = JSON.parse(readFileSync(0, "utf8"));

const WARM_UP = 5; // rounds that do not count: V8 compiles the functions that are called often

/** Seconds of the processor that `work` takes; other programs on the machine do not count. */
function seconds(work) {
  const start = process.cpuUsage();
  work();
  const { user, system } = process.cpuUsage(start);
  return 1e-6 * (user + system);
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
for (let round = -WARM_UP; round < rounds; round++) {
  for (const [name, [count, work]] of Object.entries(blocks)) {
    const time = seconds(work) / count;
    if (round >= 0) times[name].push(time);
  }
}
process.stdout.write(JSON.stringify({ times, v8: process.versions.v8 }));
