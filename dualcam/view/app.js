/** Starts the page: reads its content, makes the engine, connects model, drawings and controls. */
import { readColours } from "dualcam/chart";
import { Controls } from "dualcam/controls";
import { Engine } from "dualcam/engine";
import { Probe } from "dualcam/geometry";
import { isTyping } from "dualcam/pointer";
import { Drawings } from "dualcam/drawings";
import { Player } from "dualcam/player";
import { designScene, PRESETS } from "dualcam/presets";
import { giveAccess } from "dualcam/script_access";

const element = (id) => document.getElementById(id);
const content = JSON.parse(element("content").textContent);
const calm = window.matchMedia("(prefers-reduced-motion: reduce)").matches;

/** Bytes of the WebAssembly module. */
function modelBytes() {
  const text = atob(element("model").textContent);
  return Uint8Array.from(text, (letter) => letter.charCodeAt(0));
}

function say(message) {
  element("message-text").textContent = message;
  element("message").hidden = false;
}

function unsay() {
  element("message").hidden = true;
}

class Page {
  async start() {
    const wasm = modelBytes();
    this.create = (start) => Engine.create(wasm, content.description, content.files, start);
    const engine = await this.create(content.start);
    this.probe = await Probe.create(wasm, content.description, content.files, content.start);
    this.player = new Player(engine, say);
    this.scenes = [designScene(content, this.player), ...PRESETS];
    this.controls = new Controls(content, this.player);
    this.drawings = new Drawings(this.player, this.probe, this.controls);
    this.player.watch((kind) => this.changed(kind));
    this.connect();
    this.changed("geometry");
    requestAnimationFrame((time) => this.frame(time));
    return this.player;
  }

  connect() {
    const { player } = this;
    element("play").addEventListener("click", () => this.toggle());
    element("step").addEventListener("click", () => player.stepOnce());
    element("reset").addEventListener("click", () => this.again());
    element("design").addEventListener("click", () => player.toDesign());
    element("speed").addEventListener("change", (event) => (player.speed = Number(event.target.value)));
    element("message-close").addEventListener("click", unsay);
    document.addEventListener("keydown", (event) => this.key(event));
    this.scenes.forEach((scene, k) => {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = scene.name;
      button.title = `${scene.words} (key ${k + 1})`;
      button.setAttribute("aria-pressed", "false");
      button.addEventListener("click", () => this.choose(scene.name));
      element("presets").append(button);
    });
  }

  key(event) {
    if (isTyping(event.target) || event.ctrlKey || event.metaKey || event.altKey) return;
    const speeds = element("speed");
    const turn = (by) => {
      const k = speeds.selectedIndex + by;
      if (k < 0 || k >= speeds.length) return;
      speeds.selectedIndex = k;
      speeds.dispatchEvent(new Event("change"));
    };
    const onButton = event.target instanceof HTMLButtonElement || event.target instanceof HTMLAnchorElement;
    if (event.key === " " && !onButton) this.toggle();
    else if (event.key === ".") this.player.stepOnce();
    else if (event.key.toLowerCase() === "r") this.again();
    else if (event.key === "[") turn(1);
    else if (event.key === "]") turn(-1);
    else if (/^[1-9]$/.test(event.key) && this.scenes[event.key - 1]) this.choose(this.scenes[event.key - 1].name);
    else return;
    event.preventDefault();
  }

  toggle() {
    unsay();
    if (this.player.running) this.player.pause();
    else this.player.play();
  }

  /** The scene, or else the design, from its start, with the parameters as they are now. */
  again() {
    unsay();
    this.player.again();
  }

  /** Shows a scene from its start and plays it. */
  async choose(name) {
    const scene = this.scenes.find((one) => one.name === name);
    if (scene === undefined) throw new Error(`no scene ${name}: there are ${this.scenes.map((one) => one.name).join(", ")}`);
    unsay();
    const isDesign = scene === this.scenes[0];
    if (!isDesign && !scene.engine) scene.engine = await this.create(scene.start);
    this.player.load(isDesign ? this.player.design : scene.engine, scene);
    element("speed").value = String(scene.speed ?? 1);
    this.player.speed = scene.speed ?? 1;
    this.player.play();
  }

  /** Plays the scene of the design again and again, until somebody touches the page. */
  show() {
    this.showing = true; // before the scene begins: a script that comes in between ends the scene
    this.choose(this.scenes[0].name);
    for (const name of ["pointerdown", "keydown"]) {
      document.addEventListener(name, () => (this.showing = false), { once: true });
    }
  }

  /** What a script calls first: the page's own clock rests. */
  takeOver() {
    if (this.showing) this.player.toDesign(); // ends the scene that plays by itself
    this.showing = false;
    this.scripted = true;
    if (this.player.running) this.player.pause();
  }

  changed(kind) {
    const { player, drawings } = this;
    if (kind === "clock") {
      element("play").textContent = player.running ? "Pause" : "Play";
      element("play").setAttribute("aria-label", player.running ? "Pause the clock" : "Let the clock run");
    }
    if (kind === "geometry") {
      const named = player.preset?.name;
      for (const button of element("presets").children) button.setAttribute("aria-pressed", String(button.textContent === named));
      element("preset-words").textContent = player.preset?.words ?? "Choose a scene, drag cam 2, or move the torque's slider.";
    }
    if (kind === "parameter" || kind === "torque") unsay();
    drawings.invalidate(kind);
  }

  refresh(kind) {
    this.drawings.invalidate(kind);
  }

  frame(time) {
    const passed = (time - (this.lastFrame ?? time)) / 1000;
    this.lastFrame = time;
    try {
      this.player.advance(passed);
      if (this.showing && this.player.time > this.scenes[0].seconds) this.player.restart();
      this.drawings.frame(passed);
    } catch (error) {
      this.tellFailure(error);
    } finally {
      requestAnimationFrame((next) => this.frame(next));
    }
  }

  /** A picture that cannot be drawn: the page says why, and goes on. */
  tellFailure(error) {
    if (error.message === this.failure) return; // said already
    this.failure = error.message;
    console.error(error);
    say(`The picture cannot be drawn: ${error.message}. The last picture stays.`);
  }
}

/** Light or dark: the system's wish, until the button is pressed. */
function connectTheme(page) {
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  let chosen = null;
  const apply = () => {
    const isDark = chosen ?? dark.matches;
    document.documentElement.dataset.theme = isDark ? "dark" : "light";
    element("theme").textContent = isDark ? "Light" : "Dark";
    readColours();
    page.drawings?.repaint();
  };
  dark.addEventListener("change", apply);
  element("theme").addEventListener("click", () => {
    chosen = !(chosen ?? dark.matches);
    apply();
  });
  apply();
}

/** In the frame of another page, or with #compact: the 3D view and the torque alone, and a button for the rest. */
function connectCompact() {
  const apply = (isCompact) => {
    document.body.classList.toggle("compact", isCompact);
    element("more").textContent = isCompact ? "All" : "Less";
    element("more").title = isCompact ? "Parameters, grooves, events, help" : "The 3D view and the torque alone";
  };
  const wanted = () => location.hash === "#compact" || (window.self !== window.top && location.hash !== "#full");
  const start = () => {
    element("more").hidden = !wanted();
    apply(wanted());
  };
  start();
  window.addEventListener("hashchange", () => {
    if (["", "#compact", "#full"].includes(location.hash)) start();
  });
  element("more").addEventListener("click", () => apply(!document.body.classList.contains("compact")));
}

async function begin() {
  const page = new Page();
  connectCompact();
  connectTheme(page);
  element("note").textContent = content.note;
  element("note").hidden = !content.note;
  const started = page.start();
  giveAccess(started, {
    takeOver: () => page.takeOver(),
    refresh: (kind) => page.refresh(kind),
    choose: (name) => page.choose(name),
  });
  try {
    await started;
  } catch (error) {
    say(
      typeof WebAssembly === "undefined"
        ? "This browser has no WebAssembly, so the model cannot run. Use a current Firefox, Chrome, Edge or Safari," +
          " and allow WebAssembly in its settings."
        : `The model does not start: ${error.message}`,
    );
    throw error;
  }
  if (!calm && !page.scripted) page.show();
}

begin();
