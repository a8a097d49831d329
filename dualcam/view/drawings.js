/** All pictures of the page, each drawn anew only where something has changed. */
import { colours, readColours } from "dualcam/chart";
import { at, slopes } from "dualcam/geometry";
import { GrooveChart } from "dualcam/groove_chart";
import { handWords, Pointer } from "dualcam/pointer";
import { FRAME_NAMES, Readouts } from "dualcam/readouts";
import { MechanismView } from "dualcam/scene";
import { TimeChart } from "dualcam/time_chart";
import { TorqueChart } from "dualcam/torque_chart";
import { text } from "dualcam/units";

const element = (id) => document.getElementById(id);
const SLOW_FRAME = 0.028; // s: above this the 3D view gets fewer pixels
const FAST_FRAME = 0.018; // s: below this the view gets more
const LEAST_QUALITY = 0.35;
const NUMBERS = 70; // ms between two pictures of the numbers
const TRIAL = 8; // frames between two changes of the quality
const STILL = 0.35; // s without motion, after which the picture is drawn once in full quality
const PIN_SHARE = 0.085; // radius of the drawn pin over the smaller radius of the cams
const HINT = "Drag cam 2 to turn it. Drag beside it to look around.";
const LABELS = { cam1: "cam 1, fixed", cam2: "cam 2", pin: "pin", spring: "spring" };

export class Drawings {
  /**
   * @param {import("dualcam/player").Player} player
   * @param {import("dualcam/geometry").Probe} probe
   * @param {import("dualcam/controls").Controls} controls
   */
  constructor(player, probe, controls) {
    Object.assign(this, { player, probe, controls });
    this.torque = new TorqueChart(element("torque"));
    this.grooves = [1, 2].map((number) => new GrooveChart(element(`groove${number}`), number));
    this.times = new TimeChart(element("times"));
    this.readouts = new Readouts();
    this.stale = { shape: true, band: true, fields: true };
    this.pace = 1 / 60;
    this.frames = 0;
    this.trial = 0;
    this.shown = -Infinity;
    this.makeView();
    new ResizeObserver(() => this.invalidate("size")).observe(document.body);
  }

  /** The 3D view, or words where there is no WebGL. */
  makeView() {
    try {
      this.view = new MechanismView(element("view"));
    } catch {
      element("view").hidden = true;
      element("view").style.display = "none";
      element("no-view").hidden = false;
      return;
    }
    new Pointer(this.view, this.player, () => this.invalidate("view"));
    this.labels = Object.entries(LABELS).map(([name, words]) => {
      const label = document.createElement("span");
      label.textContent = words;
      label.style.color = `var(--${name})`;
      const line = document.createElementNS("http://www.w3.org/2000/svg", "line");
      line.style.stroke = `var(--${name})`;
      element("leaders").append(line);
      element("labels").append(label);
      return [name, label, line];
    });
  }

  /** Something has changed: what must be made anew? */
  invalidate(kind) {
    this.dirty = true;
    if (["geometry", "parameter", "reset"].includes(kind)) this.stale = { shape: true, band: true, fields: true };
    if (kind === "geometry" || kind === "reset") this.readouts.restart();
    if (kind === "torque") this.stale.band = true;
  }

  repaint() {
    readColours();
    this.view?.paint();
    this.dirty = true;
  }

  /** @param {number} passed seconds since the last frame */
  frame(passed) {
    const { player } = this;
    if (!player.running && !this.dirty && (this.isFine || !this.view)) return;
    if (player.running) this.keepPace(passed);
    this.dirty = false;
    this.renew();
    const values = player.engine.getAll(FRAME_NAMES);
    const now = Object.fromEntries(FRAME_NAMES.map((name, k) => [name, values[k]]));
    this.drawView(now);
    this.showNumbers(now);
    this.frames += 1;
    const part = this.pace > SLOW_FRAME && player.running ? this.frames % 3 : 3; // a slow machine: one chart per frame
    if (part === 0 || part === 3) this.torque.draw(player);
    if (part === 1 || part === 3) this.drawGrooves(now);
    if (part === 2 || part === 3) this.drawTimes();
  }

  /** Numbers change at a rate at which a reader can follow, and at once where the clock rests. */
  showNumbers(now) {
    const time = performance.now();
    if (this.player.running && time - this.shown < NUMBERS) return;
    this.shown = time;
    this.readouts.draw(now);
    this.readouts.drawEvents(this.player.events, now.events);
    this.controls.refreshInputs();
  }

  /** Fewer pixels where frames take long, more where there is time. */
  keepPace(passed) {
    if (passed <= 0 || passed > 1 || !this.view) return;
    this.pace += 0.2 * (passed - this.pace);
    this.trial += 1;
    if (this.trial < TRIAL) return;
    const { view } = this;
    if (this.pace > SLOW_FRAME) {
      const share = Math.max(0.6, Math.sqrt(SLOW_FRAME / this.pace)); // pixels go with the square of the quality
      view.quality = Math.max(LEAST_QUALITY, view.quality * share);
    } else if (this.pace < FAST_FRAME) view.quality = Math.min(1, view.quality * 1.08);
    this.trial = 0;
  }

  renew() {
    const { player, stale } = this;
    this.stale = { shape: false, band: false, fields: false }; // first: a refusal in here must not come again
    if (stale.shape) this.renewShape();
    if (stale.band || stale.shape) this.renewBand();
    if (stale.fields) this.controls.refresh();
    element("hand").hidden = player.hand === null;
  }

  renewShape() {
    const shape = this.probe.shape(this.player.engine);
    const key = JSON.stringify(shape);
    if (key === this.key) return;
    this.key = key;
    this.shape = shape;
    this.pin = 1e3 * PIN_SHARE * Math.min(...shape.radius);
    const phi = shape.theta.map((theta, k) => theta - shape.gamma[k]);
    this.curves = [shape.gamma, phi].map((psi, k) => {
      const x = psi.map((angle) => 1e3 * shape.radius[k] * angle);
      const z = shape.z.map((one) => 1e3 * one);
      return { x, z, slope: slopes(x, z) };
    });
    if (this.view) {
      this.view.build(shape);
      const words = [HINT];
      if (this.view.drawnApart) words.push("The radii are drawn apart.");
      if (Math.abs(this.view.stretch - 1) > 0.02) words.push(`z is drawn ${text(this.view.stretch, 2)} times as large.`);
      element("apart").textContent = words.join(" ");
    }
  }

  renewBand() {
    const { player, shape } = this;
    const theta = shape.theta;
    const { load, release } = player.engine.band(theta);
    this.torque.setBand({ theta, load: [...load], release: [...release] }, player.torqueScale);
    this.controls.setTorqueRange(player.torqueScale);
    const force = (z) => {
      const get = (name) => player.engine.get(`spring.${name}`);
      return get("preload") + z * (get("stiffness") + z * (get("stiffness2") + z * get("stiffness3")));
    };
    this.reaction = Math.max(1e-9, force(shape.z[shape.z.length - 1]) / shape.contacts);
    this.grooves.forEach((groove, k) => groove.setCurve(this.curves[k], this.pin, this.reaction));
  }

  drawView(now) {
    if (!this.view) return;
    const torque = now.tau / this.player.torqueScale;
    const { clientWidth, clientHeight } = this.view.canvas;
    const key = [now.theta, now.gamma, torque, this.key, colours.panel, clientWidth, clientHeight];
    const seen = [...key, ...Object.values(this.view.direction)].join();
    if (this.player.hand !== null) element("hand").textContent = handWords(this.player);
    const moves = seen !== this.seen;
    const time = performance.now() / 1000;
    if (moves) this.moved = time;
    else if (this.isFine || time - this.moved < STILL) return; // no new picture
    this.seen = seen;
    this.isFine = !moves;
    this.view.draw({ theta: now.theta, gamma: now.gamma, z: now.z, torque }, moves ? this.view.quality : this.view.stillQuality);
    if (moves) this.placeLabels();
  }

  /** Names of the parts beside the mechanism, with a line to the part. */
  placeLabels() {
    const places = this.view.labels();
    for (const [name, label, line] of this.labels) {
      const { point, side, x } = places[name];
      const ends = { x1: point[0], y1: point[1], x2: x, y2: point[1] };
      for (const [key, value] of Object.entries(ends)) line.setAttribute(key, value.toFixed(1));
      label.style.transform = `translate(${x.toFixed(1)}px, ${point[1].toFixed(1)}px) translate(${side < 0 ? -100 : 0}%, -50%)`;
    }
  }

  drawGrooves(now) {
    const psi = [now.gamma, now.theta - now.gamma];
    const sigma = now.mode === 2 || now.mode === 3 ? Math.sign(now.omega) : 0;
    this.grooves.forEach((groove, k) => {
      const name = `cam${k + 1}`;
      groove.draw({
        x: 1e3 * this.shape.radius[k] * psi[k],
        z: 1e3 * now.z,
        slope: at(this.shape, this.curves[k].slope, now.theta),
        reaction: now[`${name}.reaction`],
        friction: this.player.engine.get(`${name}.friction_coefficient`),
        sigma,
      });
    });
  }

  drawTimes() {
    const { rangeX, chart } = this.torque;
    const room = 0.05 * (rangeX[1] - rangeX[0]);
    const [least, most] = this.player.extremes;
    const rangeTau = [Math.min(chart.y[0], 1.05 * least), Math.max(chart.y[1], 1.05 * most)];
    this.times.draw(this.player, [rangeX[0] - room, rangeX[1] + room], rangeTau);
  }
}
