/** Numbers and units as the page shows them. */

/** FMU unit -> usual unit and its factor: usual = factor * SI. */
export const USUAL = {
  "rad": ["deg", 180 / Math.PI],
  "rad/s": ["deg/s", 180 / Math.PI],
  "m": ["mm", 1e3],
  "m/s": ["mm/s", 1e3],
  "N/m": ["N/mm", 1e-3],
  "N/m2": ["N/mm2", 1e-6],
  "N/m3": ["N/mm3", 1e-9],
  "kg.m2": ["kg.cm2", 1e4],
};

/** The unit in which the page shows a variable, and its factor. */
export function shownUnit(unit) {
  return USUAL[unit] ?? [unit === "1" || !unit ? "" : unit, 1];
}

/**
 * A number for reading.
 * @param {number} value
 * @param {number} [digits] significant digits
 */
export function text(value, digits = 4) {
  if (Number.isNaN(value)) return "not a number";
  if (!Number.isFinite(value)) return value > 0 ? "infinite" : "-infinite";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size < 1e-4 || size >= 1e6) return value.toExponential(Math.max(0, digits - 2)).replace("e+", "e");
  return String(Number(value.toPrecision(digits)));
}

/** A number with a fixed count of decimals, so that a changing value does not jump sideways. */
export function fixed(value, decimals) {
  if (!Number.isFinite(value)) return text(value);
  const written = value.toFixed(decimals);
  return Number(written) === 0 ? written.replace("-", "") : written;
}

/** The modes of the FMU: number -> word and what the word means. */
export const MODES = {
  1: ["stick", "Friction holds cam 2. The torque is inside the stick band."],
  2: ["loading", "Cam 2 turns forward. The spring is compressed."],
  3: ["releasing", "Cam 2 turns back. The spring relaxes."],
  4: ["lower stop", "Cam 2 rests at the lower end stop."],
  5: ["upper stop", "Cam 2 rests at the upper end stop."],
  6: ["wedged", "The pin is wedged between the grooves. No torque in the releasing direction moves cam 2."],
};

/** Limits between `low` and `high`. */
export function clamp(value, low, high) {
  return Math.min(high, Math.max(low, value));
}
