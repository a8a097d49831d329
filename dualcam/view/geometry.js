/** The shape of the mechanism, sampled with a second instance of the model. */
import { Engine } from "dualcam/engine";

const POINTS = 73;
const GEOMETRY = ["cam1.", "cam2.", "stop.", "inertia.", "contacts"]; // parameters that the probe needs

/**
 * @typedef {object} Shape
 * @property {number[]} theta from one end stop to the other [rad]
 * @property {number[]} gamma angle of the pin about the axis [rad]
 * @property {number[]} z place of the pin along the axis [m]
 * @property {[number, number]} radius of cam 1 and cam 2 [m]
 * @property {number} contacts
 */

/** Angles from one end stop to the other. */
export function anglesOf(engine, count = POINTS) {
  const low = engine.get("stop.lower");
  const high = engine.get("stop.upper");
  // low + (high - low) can be above high by rounding, and the model refuses such an angle
  return Array.from({ length: count }, (_, k) => Math.min(high, low + ((high - low) * k) / (count - 1)));
}

/** A second instance of the same model, which is moved along theta to read the place of the pin. */
export class Probe {
  static async create(wasm, description, files, start) {
    const probe = new Probe();
    probe.engine = await Engine.create(wasm, description, files, { ...start, "initial.omega": 0 });
    probe.names = description.variables
      .filter((v) => v.causality === "parameter" && GEOMETRY.some((prefix) => v.name.startsWith(prefix)))
      .map((v) => v.name);
    return probe;
  }

  /**
   * Curves over theta.
   * @param {Engine} engine the instance that the page shows
   * @returns {Shape}
   */
  shape(engine) {
    const values = Object.fromEntries(this.names.map((name) => [name, engine.get(name)]));
    const theta = anglesOf(engine);
    const rows = theta.map((angle) => {
      this.engine.setAll({ ...values, "initial.theta": angle });
      return this.engine.getAll(["gamma", "z"]);
    });
    return {
      theta,
      gamma: rows.map((row) => row[0]),
      z: rows.map((row) => row[1]),
      radius: [values["cam1.radius"], values["cam2.radius"]],
      contacts: values.contacts,
    };
  }
}

/** Slopes dz/dx by central differences. */
export function slopes(x, z) {
  const last = x.length - 1;
  return x.map((_, k) => {
    const [a, b] = [Math.max(0, k - 1), Math.min(last, k + 1)];
    return x[b] > x[a] ? (z[b] - z[a]) / (x[b] - x[a]) : 0;
  });
}

/** Linear interpolation of `values` at the angle `theta`. */
export function at(shape, values, theta) {
  const t = shape.theta;
  const last = t.length - 1;
  const place = Math.min(last - 1e-9, Math.max(0, ((theta - t[0]) / (t[last] - t[0])) * last));
  const k = Math.floor(place);
  return values[k] + (values[k + 1] - values[k]) * (place - k);
}
