/** Mode, readings, energy bars and the list of events. */
import { fixed, MODES, text } from "dualcam/units";

const DEGREE = 180 / Math.PI;

/** Name, words, factor, decimals, unit. */
const READINGS = [
  ["theta", "angle theta", DEGREE, 2, "deg"],
  ["omega", "speed omega", 1, 3, "rad/s"],
  ["tau", "torque tau", 1, 3, "N.m"],
  ["z", "stroke z", 1e3, 3, "mm"],
  ["spring.force", "spring force", 1, 1, "N"],
  ["efficiency", "efficiency", 100, 1, "%"],
];

/** Account, words, colour of the style sheet. */
const ENERGIES = [
  ["energy.work_in", "work of the torque", "accent"],
  ["energy.spring", "spring", "spring"],
  ["energy.kinetic", "motion", "trail"],
  ["energy.heat_cam1", "heat at cam 1", "cam1"],
  ["energy.heat_cam2", "heat at cam 2", "cam2"],
  ["energy.heat_damper", "heat of the damper", "pin"],
  ["energy.heat_shaft", "heat at the shaft", "pin"],
  ["energy.heat_stop", "heat at the stops", "pin"],
  ["energy.work_ext", "against F_ext", "soft"],
  ["energy.work_tuning", "by tuning", "soft"],
];
const RARE = ["energy.heat_damper", "energy.heat_shaft", "energy.heat_stop", "energy.work_ext", "energy.work_tuning"];

/** What a drawing of one frame needs. */
export const FRAME_NAMES = [
  ...READINGS.map(([name]) => name),
  ...ENERGIES.map(([name]) => name),
  ...["energy.residual", "mode", "events", "gamma", "cam1.reaction", "cam2.reaction", "time"],
];

const element = (id) => document.getElementById(id);

export class Readouts {
  constructor() {
    this.values = new Map();
    for (const [name, words, , , unit] of READINGS) {
      const box = document.createElement("div");
      box.innerHTML = `<dt></dt><dd></dd>`;
      box.firstChild.textContent = words;
      element("readings").append(box);
      this.values.set(name, { number: box.lastChild, unit });
    }
    for (const [name, words, colour] of ENERGIES) this.values.set(name, this.addBar(words, colour));
    this.residual = this.addBar("residual", "soft");
    this.residual.box.title = "Error of the energy balance: work in minus all accounts";
    this.residual.fill.parentNode.style.visibility = "hidden";
    this.scale = 1e-6;
  }

  addBar(words, colour) {
    const box = document.createElement("div");
    box.className = "bar";
    box.innerHTML = `<span></span><span class="track"><span class="fill"></span></span><span class="number"></span>`;
    box.firstChild.textContent = words;
    const fill = box.querySelector(".fill");
    fill.style.display = "block";
    fill.style.background = `var(--${colour})`;
    element("energy").append(box);
    return { box, fill, number: box.querySelector(".number") };
  }

  /** @param {Record<string, number>} now values of FRAME_NAMES */
  draw(now) {
    for (const [name, , factor, decimals, unit] of READINGS) {
      if (name === "efficiency" && now[name] <= 0) this.values.get(name).number.textContent = "self-locking";
      else this.values.get(name).number.textContent = `${fixed(now[name] * factor, decimals)} ${unit}`;
    }
    const [word, meaning] = MODES[now.mode] ?? [String(now.mode), ""];
    element("mode").textContent = word;
    element("mode").dataset.mode = now.mode;
    element("mode-words").textContent = meaning;
    element("clock").textContent = `${fixed(now.time, 3)} s`;
    this.drawEnergy(now);
  }

  /** Another run: the bars find their scale anew. */
  restart() {
    this.scale = 1e-6;
  }

  drawEnergy(now) {
    const sizes = ENERGIES.map(([name]) => Math.abs(now[name]));
    this.scale = Math.max(1e-6, ...sizes, 0.98 * this.scale); // falls slowly, so that bars do not jump
    for (const [name] of ENERGIES) {
      const { box, fill, number } = this.values.get(name);
      box.hidden = RARE.includes(name) && Math.abs(now[name]) < 1e-9;
      box.style.display = box.hidden ? "none" : "";
      fill.classList.toggle("negative", now[name] < 0);
      fill.style.transform = `scaleX(${Math.min(1, Math.abs(now[name]) / this.scale)})`;
      number.textContent = `${fixed(now[name], 4)} J`;
    }
    this.residual.number.textContent = `${text(now["energy.residual"], 3)} J`;
  }

  /** @param {{time: number, from: number, to: number, theta: number, between: number}[]} events */
  drawEvents(events, count) {
    if (this.last === events[events.length - 1] && this.length === events.length) return;
    this.last = events[events.length - 1];
    this.length = events.length;
    const rows = events
      .slice(-60)
      .reverse()
      .map(({ time, from, to, theta, between }) => {
        const row = document.createElement("li");
        const hidden = between > 0 ? ` (${between} more in this step)` : "";
        const words = [`${fixed(time, 3)} s`, `${MODES[from][0]} → ${MODES[to][0]}${hidden}`, `${fixed(theta * DEGREE, 2)} deg`];
        for (const word of words) row.append(Object.assign(document.createElement("span"), { textContent: word }));
        return row;
      });
    element("events").replaceChildren(...rows);
    element("event-count").textContent = count ? `${count} so far` : "";
  }
}
