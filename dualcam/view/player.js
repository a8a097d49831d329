/**
 * The clock of the page: it steps the engine in real time, applies torque from slider, preset and hand, and
 * keeps what the drawings show (trail, events, largest torque).
 */
import { ModelError } from "dualcam/engine";
import { clamp } from "dualcam/units";

const MICRO_STEP = 1e-3; // s of the model: torque of the hand and of histories is constant over one such step
const CATCH_UP = 0.05; // s: a longer pause between two frames is not made up for
const FRAME_BUDGET = 8; // ms of computing for one frame; what is left over is dropped
const TRAIL = 3000; // points
const MOST_EVENTS = 200;

/** Linear interpolation in a history; the value stands still before and after. Two equal times are a jump. */
export function valueAt(history, time) {
  const { time: t, value: x } = history;
  if (time >= t[t.length - 1]) return x[x.length - 1];
  let k = 0;
  while (k < t.length && t[k] <= time) k += 1;
  if (k === 0) return x[0];
  return x[k - 1] + ((x[k] - x[k - 1]) * (time - t[k - 1])) / (t[k] - t[k - 1]);
}

/** The text of a refusal without the name of the FMI function. */
const withoutFunction = (message) => message.replace(/^fmi2\w+: /, "").replace(/\.$/, "");

export class Player {
  /**
   * @param {import("dualcam/engine").Engine} engine of the design
   * @param {(message: string) => void} say shows a message, such as a refusal of the model
   */
  constructor(engine, say) {
    this.design = engine; // for reset()
    this.engine = engine;
    this.say = say;
    this.running = false;
    this.speed = 1;
    this.preset = null;
    this.histories = {};
    this.drive = null; // a shaft that a motor turns: {stiffness, speed, until}
    this.hand = null; // angle that the hand wants [rad]
    this.base = { tau: 0, F_ext: 0 }; // what the sliders say
    this.sent = {};
    this.watchers = new Set();
    this.clear();
    this.measureHand();
  }

  /** Calls `watcher(kind)` at "reset", "geometry", "parameter", "torque" and "clock". */
  watch(watcher) {
    this.watchers.add(watcher);
  }

  tell(kind) {
    for (const watcher of this.watchers) watcher(kind);
  }

  get time() {
    return this.engine.time;
  }

  /** Forget what was recorded. */
  clear() {
    this.trail = []; // [theta, tau, time] of each micro step
    this.extremes = [0, 0]; // least and largest torque
    this.events = []; // {time, from, to, theta}
    this.mode = this.engine.get("mode");
    this.count = this.engine.get("events");
  }

  /** The stiffness of the hand: at most half the least stiffness and a twentieth of the inertia's limit. */
  measureHand() {
    const get = (name) => this.engine.get(name);
    const span = get("stop.upper") - get("stop.lower");
    const band = this.engine.band([get("stop.lower"), get("stop.upper")]);
    const finite = [...band.load, ...band.release].filter(Number.isFinite).map(Math.abs);
    this.torqueScale = Math.max(1e-9, ...finite);
    const inertia = get("inertia.shaft");
    const wanted = (8 * this.torqueScale) / span;
    const bound = inertia > 0 ? (0.05 * inertia) / MICRO_STEP ** 2 : (0.3 * this.torqueScale) / span;
    const stiffness = Math.min(wanted, bound);
    this.grip = {
      stiffness,
      damping: inertia > 0 ? Math.min(1.4 * Math.sqrt(stiffness * inertia), (0.3 * inertia) / MICRO_STEP) : 0,
      most: 1.6 * this.torqueScale,
    };
  }

  /** Torque of the hand [N.m]: a spring and a damper between the wanted angle and cam 2, limited. */
  handTorque() {
    if (this.hand === null) return 0;
    const { stiffness, damping, most } = this.grip;
    const pull = stiffness * (this.hand - this.engine.get("theta")) - damping * this.engine.get("omega");
    return clamp(pull, -most, most);
  }

  /** The hand takes cam 2 at this angle; the clock runs while it does. */
  hold(angle) {
    this.hand = angle;
    this.play();
  }

  /** Moves the hand [rad]. It cannot be further away than its largest torque needs. */
  moveHand(by) {
    const theta = this.engine.get("theta");
    const reach = (1.1 * this.grip.most) / this.grip.stiffness;
    this.hand = clamp(this.hand + by, theta - reach, theta + reach);
  }

  letGo() {
    this.hand = null;
    this.tell("clock");
  }

  /** Torque of a motor that turns at constant speed behind a soft shaft [N.m]. */
  driveTorque() {
    const { stiffness, speed, until } = this.drive;
    return stiffness * (speed * Math.min(this.time, until) - this.engine.get("theta"));
  }

  /** Inputs of the next micro step, sent only where they changed. */
  sendInputs() {
    const middle = this.time + 0.5 * MICRO_STEP;
    for (const name of ["tau", "F_ext"]) {
      const history = this.histories[name];
      if (history) this.base[name] = valueAt(history, middle);
    }
    if (this.drive !== null) this.base.tau = this.driveTorque();
    this.send("tau", this.base.tau + this.handTorque());
    this.send("F_ext", this.base.F_ext);
  }

  send(name, value) {
    if (this.sent[name] === value) return;
    this.engine.set(name, value);
    this.sent[name] = value;
  }

  /**
   * Let real time pass.
   * @param {number} seconds since the last frame
   */
  advance(seconds) {
    if (!this.running) return;
    let left = Math.min(seconds, CATCH_UP) * this.speed;
    const deadline = performance.now() + FRAME_BUDGET;
    while (left > 1e-9 && performance.now() < deadline && this.running) {
      const step = Math.min(MICRO_STEP, left);
      this.microStep(step);
      left -= step;
    }
  }

  microStep(step) {
    try {
      this.sendInputs();
      this.engine.step(step);
    } catch (error) {
      if (!(error instanceof ModelError)) throw error;
      this.hand = null;
      this.pause();
      this.say(`${withoutFunction(error.message)}. The clock rests. Change a value, or press Reset.`);
      return;
    }
    this.record();
  }

  /** After a step: one point of the trail, and the change of mode. */
  record() {
    const { engine } = this;
    const tau = engine.get("tau");
    this.trail.push([engine.get("theta"), tau, engine.time]);
    this.extremes = [Math.min(this.extremes[0], tau), Math.max(this.extremes[1], tau)];
    if (this.trail.length > TRAIL) this.trail.splice(0, TRAIL / 4);
    const mode = engine.get("mode");
    const count = engine.get("events");
    if (mode !== this.mode || count !== this.count) {
      const between = count - this.count - (mode === this.mode ? 0 : 1); // changes that the step hides
      this.events.push({ time: engine.time, from: this.mode, to: mode, theta: engine.get("theta"), between });
      if (this.events.length > MOST_EVENTS) this.events.shift();
      this.mode = mode;
      this.count = count;
    }
  }

  play() {
    this.running = true;
    this.tell("clock");
  }

  pause() {
    this.running = false;
    this.tell("clock");
  }

  /** One micro step; the clock rests. */
  stepOnce() {
    this.running = false;
    this.microStep(MICRO_STEP);
    this.tell("clock");
  }

  /** As many micro steps as a time of the model takes [s]. */
  run(seconds) {
    const count = Math.round(seconds / MICRO_STEP);
    for (let k = 0; k < count; k += 1) this.microStep(MICRO_STEP);
  }

  /**
   * A script has set a variable: the clock later goes on with what the script has set.
   * @returns {"torque" | "parameter"} what has changed
   */
  scripted(name) {
    if (name in this.base) {
      delete this.histories[name];
      if (name === "tau") this.drive = null;
      this.base[name] = this.engine.get(name);
      this.sent[name] = this.base[name];
      return "torque";
    }
    this.parametersChanged();
    this.sayWhetherAnew(name);
    return "parameter";
  }

  parametersChanged() {
    this.mode = this.engine.get("mode");
    this.count = this.engine.get("events"); // starts at 0 again where the model starts anew
    this.measureHand();
  }

  /** From the start with the present parameters. A refusal is shown, and the present state stays. */
  again() {
    try {
      this.engine.again();
    } catch (error) {
      if (!(error instanceof ModelError)) throw error;
      this.say(`${withoutFunction(error.message)}. The present state stays.`);
      return;
    }
    this.restoreScene();
    this.restarted("reset");
  }

  /** Start values of the design or preset; history, trail and events from the start. */
  restart() {
    this.engine.reset();
    this.restoreScene();
    this.restarted("reset");
  }

  /** Back to the design as the page was made. */
  toDesign() {
    this.engine = this.design;
    this.preset = null;
    this.histories = {};
    this.drive = null;
    this.engine.reset();
    this.restarted("geometry");
  }

  /**
   * Another mechanism: a preset.
   * @param {import("dualcam/engine").Engine} engine
   * @param {object} preset
   */
  load(engine, preset) {
    this.engine = engine;
    this.preset = preset;
    this.engine.reset();
    this.restoreScene();
    this.restarted("geometry");
  }

  /** Torque histories and drive of the scene, from their start. */
  restoreScene() {
    this.histories = { ...this.preset?.histories };
    this.drive = this.preset?.drive ?? null;
  }

  restarted(kind) {
    this.hand = null;
    this.sent = {};
    this.base = { tau: this.engine.get("tau"), F_ext: this.engine.get("F_ext") };
    this.clear();
    this.measureHand();
    this.tell(kind);
  }

  /** The sliders' torque or force: ends the history of that input. */
  setInput(name, value) {
    delete this.histories[name];
    if (name === "tau") this.drive = null;
    this.base[name] = value;
    if (!this.running) this.send(name, value);
    this.tell("torque");
  }

  /**
   * A parameter. A refusal is shown, and the last good state stays.
   * @returns {boolean} whether the model took the value
   */
  setParameter(name, value) {
    try {
      this.engine.set(name, value);
    } catch (error) {
      if (!(error instanceof ModelError)) throw error;
      this.say(`${withoutFunction(error.message)}. The last good value stays.`);
      return false;
    }
    this.parametersChanged();
    this.tell("parameter");
    this.sayWhetherAnew(name);
    return true;
  }

  /** A message where a new value of the parameter has ended the run and begun another one. */
  sayWhetherAnew(name) {
    if (this.time === 0 || !this.engine.startsAnew(name)) return;
    const where = name.startsWith("initial.") ? "at this start" : "with the present angle and speed";
    this.say(`${name} is fixed during a run: the model began anew ${where}. Energies, peaks and events count from here.`);
  }
}
