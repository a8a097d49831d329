/** Sliders and number fields for inputs and parameters, made from the FMU's model description. */
import { clamp, shownUnit, text } from "dualcam/units";

/** End of a name -> sensible range in SI units. Others: 0 to four times the start value. */
const RANGES = {
  "radius": [0.005, 0.1],
  "lead_angle": [0, Math.PI / 2],
  "ellipse_a": [0.01, 0.2],
  "ellipse_b": [0.01, 0.2],
  "friction": [0, 0.6],
  "friction_peak": [1, 3],
  "stribeck_velocity": [0.001, 0.1],
  "friction_viscous": [0, 1],
  "friction_load_exponent": [-0.5, 0.5],
  "friction_load": [10, 1000],
  "wear": [0, 1e-13],
  "preload": [0, 500],
  "stiffness": [0, 200e3],
  "stiffness2": [0, 5e6],
  "stiffness3": [0, 2e8],
  "c_load": [0, 2000],
  "c_release": [0, 2000],
  "q_load": [0, 20e3],
  "q_release": [0, 20e3],
  "shaft": [0, 0.02],
  "follower_mass": [0, 5],
  "follower": [0, 0.005],
  "damping": [0, 0.5],
  "lower": [-1, 1],
  "upper": [0.2, 3],
  "restitution": [0, 1],
  "theta": [0, 1.3962634],
  "omega": [-20, 20],
};

const WORDS = {
  "ellipse_curvature": { "-1": "flattens", "1": "steepens" },
  "contacts": { 1: "1", 2: "2" },
  "stribeck_exponent": { 1: "1 (Tustin)", 2: "2 (Gauss)" },
};

const GROUPS = {
  cam1: "Cam 1 (fixed)",
  cam2: "Cam 2 (turns)",
  spring: "Spring",
  damper: "Damper",
  inertia: "Inertia",
  shaft: "Shaft",
  stop: "End stops",
  initial: "Start",
  "": "General",
};

const WIDE = 700; // pixels: a narrower page begins with closed groups

const ending = (name) => name.slice(name.indexOf(".") + 1);

/** One input or parameter in the page. `send(value)` returns whether the model took the value. */
class Field {
  constructor(variable, send, files) {
    this.variable = variable;
    this.send = send;
    [this.unit, this.factor] = shownUnit(variable.unit);
    this.digits = variable.causality === "input" ? 4 : 6;
    this.box = document.createElement("div");
    this.box.className = "field";
    this.box.dataset.name = variable.name;
    const id = `field-${variable.name}`;
    this.box.innerHTML = `<label for="${id}"></label><span class="value"></span>`;
    this.label = this.box.firstChild;
    this.label.textContent = variable.name;
    this.label.title = variable.description;
    this.entry = this.makeEntry(files);
    this.entry.id = id;
    this.entry.title = variable.description;
    this.box.children[1].append(this.entry);
    if (variable.type === "Real") this.addSlider();
  }

  makeEntry(files) {
    const { type, name, words } = this.variable;
    if (type === "Real") {
      const entry = document.createElement("input");
      entry.type = "number";
      entry.step = "any";
      entry.addEventListener("change", () => this.submit(Number(entry.value) / this.factor, entry.value));
      return entry;
    }
    const entry = document.createElement("select");
    const options =
      type === "String"
        ? Object.fromEntries(["", ...Object.keys(files)].map((file) => [file, file || "none"]))
        : type === "Boolean"
          ? { true: "yes", false: "no" }
          : (words ?? WORDS[ending(name)] ?? integers(this.variable));
    for (const [value, word] of Object.entries(options)) entry.add(new Option(word, value));
    const read = { String: String, Boolean: (value) => value === "true", Integer: Number }[type];
    entry.addEventListener("change", () => this.submit(read(entry.value)));
    return entry;
  }

  addSlider() {
    const { variable } = this;
    const unit = document.createElement("span");
    unit.className = "unit";
    unit.textContent = this.unit;
    this.box.children[1].append(unit);
    this.slider = document.createElement("input");
    this.slider.type = "range";
    this.slider.setAttribute("aria-label", `${variable.name} ${this.unit}`);
    this.slider.addEventListener("input", () => this.submit(clamp(Number(this.slider.value), this.low, this.high), "", true));
    this.slider.addEventListener("change", () => this.show(this.shown));
    this.box.append(this.slider);
    if (this.unit === "deg") {
      this.other = document.createElement("span");
      this.other.className = "other";
      this.box.classList.add("angle");
      this.box.append(this.other);
    }
    const known = RANGES[ending(variable.name)];
    const most = 4 * Math.abs(variable.start ?? 1) || 1;
    this.setRange(known ?? [variable.min < 0 || variable.min === null ? -most : 0, most]);
  }

  /** The slider's range within what the FMU allows. */
  setRange([low, high]) {
    this.low = Math.max(low, this.variable.min ?? -Infinity);
    this.high = Math.min(high, this.variable.max ?? Infinity);
    this.slider.min = this.low;
    this.slider.max = this.high;
    this.slider.step = (this.high - this.low) / 1000;
  }

  submit(value, typed = "0", sliding = false) {
    const taken = typed.trim?.() === "" && !sliding ? false : this.send(value);
    this.box.classList.toggle("refused", !taken);
    if (taken) this.show(value, sliding);
    else if (!sliding) this.show(this.shown);
  }

  /** Shows a value of the model; the slider grows where the value is outside. */
  show(value, sliding = false) {
    this.shown = value;
    if (this.variable.type !== "Real") {
      this.entry.value = String(value);
      return;
    }
    if (value < this.low || value > this.high) this.setRange([Math.min(value, this.low), Math.max(value, this.high)]);
    this.entry.value = String(Number((value * this.factor).toPrecision(this.digits)));
    if (!sliding) this.slider.value = value;
    this.slider.setAttribute("aria-valuetext", `${text(value * this.factor)} ${this.unit}`);
    if (this.other) this.other.textContent = `${text(value)} rad`;
  }
}

function integers({ min, max, start }) {
  const low = min ?? start - 2;
  const count = Math.min(12, (max ?? start + 2) - low + 1);
  return Object.fromEntries(Array.from({ length: count }, (_, k) => [low + k, String(low + k)]));
}

export class Controls {
  /**
   * @param {object} content of the page: description, files, start
   * @param {() => import("dualcam/player").Player} player
   */
  constructor(content, player) {
    this.player = player;
    this.fields = new Map();
    const inputs = document.getElementById("inputs");
    const parameters = document.getElementById("parameters");
    const groups = new Map();
    for (const variable of content.description.variables) {
      const { name, causality } = variable;
      if (causality === "input") {
        this.add(variable, inputs, (value) => this.sendInput(name, value), content);
      } else if (causality === "parameter") {
        const prefix = name.includes(".") ? name.slice(0, name.indexOf(".")) : "";
        if (!groups.has(prefix)) groups.set(prefix, addGroup(parameters, GROUPS[prefix] ?? prefix));
        this.add(variable, groups.get(prefix), (value) => player.setParameter(name, value), content);
      }
    }
    this.fields.get("F_ext")?.setRange([-500, 500]);
  }

  add(variable, parent, send, content) {
    const field = new Field(variable, send, content.files);
    const own = content.start[variable.name];
    if (typeof own === "number" && own > 0.6 * field.high) field.setRange([field.low, 2 * own]);
    this.fields.set(variable.name, field);
    parent.append(field.box);
  }

  sendInput(name, value) {
    if (!Number.isFinite(value)) return false;
    this.player.setInput(name, value);
    return true;
  }

  /** Values of the model in all fields; hides what the groove laws do not use. */
  refresh() {
    const { engine } = this.player;
    for (const [name, field] of this.fields) {
      if (field.variable.causality === "parameter") {
        field.show(engine.get(name));
        field.box.classList.remove("refused");
        field.box.hidden = !isUsed(engine, field.variable);
      }
    }
    this.refreshInputs();
    const [low, high] = [engine.get("stop.lower"), engine.get("stop.upper")];
    this.fields.get("initial.theta")?.setRange([low, high]);
    this.fields.get("initial.theta")?.show(engine.get("initial.theta"));
  }

  /** The torque's slider reaches beyond the stick band. */
  setTorqueRange(scale) {
    const most = Number((1.6 * scale).toPrecision(2));
    this.fields.get("tau").setRange([-most, most]);
    this.refreshInputs();
  }

  refreshInputs() {
    for (const name of ["tau", "F_ext"]) {
      const field = this.fields.get(name);
      const [entry, slider] = [field?.entry, field?.slider];
      if (field && document.activeElement !== entry) field.show(this.player.base[name], document.activeElement === slider);
    }
  }
}

function addGroup(parent, title) {
  const group = document.createElement("details");
  group.open = window.innerWidth >= WIDE;
  const summary = document.createElement("summary");
  summary.textContent = title;
  group.append(summary);
  parent.append(group);
  return group;
}

/** Does the groove law of the cam use the parameter? */
function isUsed(engine, { name, profiles }) {
  return profiles === undefined || profiles.includes(engine.get(`${name.slice(0, 4)}.profile`));
}
