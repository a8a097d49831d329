/**
 * The FMU in a page: the C code of the mechanism as WebAssembly, behind set, get and step.
 *
 * Names, units and messages are those of the FMU (SI units: m, rad, s, N, N.m, J). The module imports nothing and
 * touches no document, so that it runs in browsers and in node alike.
 */

/** A refusal. The message is the FMU's own text: what is refused, and what is allowed. */
export class ModelError extends Error {
  name = "ModelError";
}

/**
 * A variable as modelDescription.xml of FMI 2.0 has it; vr is its value reference.
 * @typedef {{name: string, vr: number, type: "Real" | "Integer" | "Boolean" | "String",
 *   causality: "parameter" | "input" | "output" | "local",
 *   variability: "fixed" | "tunable" | "discrete" | "continuous"}} Variable
 * @typedef {number | boolean | string} Value
 * @typedef {Record<string, Value>} Values by name
 * @typedef {object} Snapshot what save() gives and restore() takes; its content belongs to the engine
 */

// ---- files ----

const RESOURCES = "/resources"; // the folder of the groove tables, as the C code sees it
const ROOT_FILE = 3; // the first number that WASI gives to a folder
const [GOOD, BAD_FILE, BAD_VALUE, NO_SUCH_FILE] = [0, 8, 28, 44]; // WASI's numbers of errors
const [FOLDER, PLAIN_FILE] = [3, 4]; // WASI's numbers of the kinds of files

/** The files that the C code reads, in memory: what it imports of the system interface WASI. */
class Files {
  #texts = new Map(); // path without its first slash -> bytes
  #open = new Map(); // number -> {bytes, place}
  memory; // WebAssembly.Memory of the module that imports these functions

  /** @param {Record<string, string>} texts name of a groove table, as cam1.table has it -> its text */
  constructor(texts) {
    for (const [name, text] of Object.entries(texts)) {
      const path = name.startsWith("/") ? name : `${RESOURCES}/${name}`;
      this.#texts.set(path.slice(1), new TextEncoder().encode(text));
    }
  }

  get #bytes() {
    return new Uint8Array(this.memory.buffer); // another buffer after the memory has grown
  }

  /** The functions by name, as WASI's wasi_snapshot_preview1 defines them. There is one folder, the root. */
  get imports() {
    return {
      environ_sizes_get: (count, size) => this.#numbers([count, 0], [size, 0]),
      environ_get: () => GOOD,
      random_get: (address, size) => this.#fill(0, address, size), // no result depends on these bytes
      proc_exit: (code) => {
        throw new Error(`the WebAssembly module has stopped with code ${code}`);
      },
      fd_prestat_get: (file, address) => (file > ROOT_FILE ? BAD_FILE : this.#numbers([address, 0], [address + 4, 1])),
      fd_prestat_dir_name: (_file, address, size) => this.#fill("/".charCodeAt(0), address, size),
      fd_fdstat_get: (file, address) => this.#describe(file, address),
      path_open: (folder, _follow, name, size, _create, _rights, _inherited, _flags, address) =>
        this.#openFile(new TextDecoder().decode(this.#bytes.slice(name, name + size)), address),
      fd_read: (file, buffers, count, address) => this.#read(file, buffers, count, address),
      fd_seek: (file, offset, from, address) => this.#seek(file, offset, from, address),
      fd_close: (file) => (this.#open.delete(file) ? GOOD : BAD_FILE),
      fd_write: () => BAD_FILE,
    };
  }

  #fill(byte, address, size) {
    this.#bytes.fill(byte, address, address + size);
    return GOOD;
  }

  #numbers(...pairs) {
    const view = new DataView(this.memory.buffer);
    for (const [address, value] of pairs) view.setUint32(address, value, true);
    return GOOD;
  }

  #describe(file, address) {
    if (file !== ROOT_FILE && !this.#open.has(file)) return BAD_FILE;
    this.#fill(0, address, 8); // no flags
    this.#fill(file === ROOT_FILE ? FOLDER : PLAIN_FILE, address, 1);
    return this.#fill(0xff, address + 8, 16); // all rights
  }

  #openFile(path, address) {
    const bytes = this.#texts.get(path);
    if (bytes === undefined) return NO_SUCH_FILE;
    let file = ROOT_FILE + 1;
    while (this.#open.has(file)) file++;
    this.#open.set(file, { bytes, place: 0 });
    return this.#numbers([address, file]);
  }

  #read(file, buffers, count, address) {
    const opened = this.#open.get(file);
    if (opened === undefined) return BAD_FILE;
    const start = opened.place;
    const list = new Uint32Array(this.memory.buffer, buffers, 2 * count);
    for (let i = 0; i < count; i++) {
      const [target, size] = list.subarray(2 * i);
      const part = opened.bytes.subarray(opened.place, opened.place + size);
      this.#bytes.set(part, target);
      opened.place += part.length;
    }
    return this.#numbers([address, opened.place - start]);
  }

  #seek(file, offset, from, address) {
    const opened = this.#open.get(file);
    if (opened === undefined) return BAD_FILE;
    const place = Number(offset) + [0, opened.place, opened.bytes.length][from];
    if (!(place >= 0)) return BAD_VALUE;
    opened.place = place;
    return this.#numbers([address, place], [address + 4, 0]);
  }
}

// ---- calls ----

const SCRATCH_SIZE = 1 << 16; // bytes for the arguments of one call
const OK = 0; // fmi2OK
const NEVER_BACK = 1; // fmi2True: no step is repeated from an earlier state

/** The functions of the FMU with arguments and results of JavaScript. One module holds any number of instances. */
class Library {
  #functions;
  #scratch;
  #guid;
  #lastView;

  static async load(wasm, guid, files) {
    if (typeof WebAssembly === "undefined") {
      throw new ModelError("this browser has no WebAssembly, in which the model is compiled: use another browser");
    }
    const library = new Library();
    const system = new Files(files);
    const { instance } = await WebAssembly.instantiate(wasm, { wasi_snapshot_preview1: system.imports });
    library.#functions = instance.exports;
    system.memory = instance.exports.memory;
    instance.exports._initialize();
    library.#scratch = instance.exports.malloc(SCRATCH_SIZE);
    library.#guid = guid;
    return library;
  }

  get #memory() {
    return this.#functions.memory.buffer; // another one after the memory has grown
  }

  get #view() {
    if (this.#lastView?.buffer !== this.#memory) this.#lastView = new DataView(this.#memory);
    return this.#lastView;
  }

  #textAt(address) {
    const bytes = new Uint8Array(this.#memory, address);
    return new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
  }

  #writeText(address, text) {
    const bytes = new TextEncoder().encode(text);
    if (bytes.length >= SCRATCH_SIZE / 4) throw new ModelError(`a text of ${bytes.length} bytes is too long`);
    new Uint8Array(this.#memory).set([...bytes, 0], address);
  }

  /** Writes references to the scratch memory. Returns the address behind them, for the values. */
  #writeReferences(references) {
    for (let i = 0; i < references.length; i++) this.#view.setUint32(this.#scratch + 4 * i, references[i], true);
    return this.#scratch + 8 * Math.ceil(references.length / 2);
  }

  #refuse() {
    throw new ModelError(this.#textAt(this.#functions.web_message()));
  }

  #check(status) {
    if (status !== OK) this.#refuse();
  }

  /** A new instance of the FMU, before its start. */
  instantiate() {
    const resources = this.#scratch + SCRATCH_SIZE / 2;
    this.#writeText(this.#scratch, this.#guid);
    this.#writeText(resources, `file://${RESOURCES}`);
    const instance = this.#functions.web_instantiate(this.#scratch, resources);
    if (instance === 0) this.#refuse();
    return instance;
  }

  free = (instance) => this.#functions.fmi2FreeInstance(instance);

  /** Starts the run at this time, s. */
  start(instance, time) {
    this.#check(this.#functions.fmi2SetupExperiment(instance, 0, 0, time, 0, 0));
    this.#check(this.#functions.fmi2EnterInitializationMode(instance));
    this.#check(this.#functions.fmi2ExitInitializationMode(instance));
  }

  step(instance, time, seconds) {
    this.#check(this.#functions.fmi2DoStep(instance, time, seconds, NEVER_BACK));
  }

  set(instance, variable, value) {
    const content = this.#writeReferences([variable.vr]);
    const view = this.#view;
    if (variable.type === "Real") view.setFloat64(content, value, true);
    else if (variable.type === "String") {
      this.#writeText(content + 8, value);
      view.setUint32(content, content + 8, true);
    } else view.setInt32(content, Number(value), true);
    this.#check(this.#functions[`fmi2Set${variable.type}`](instance, this.#scratch, 1, content));
  }

  get(instance, variable) {
    const content = this.#writeReferences([variable.vr]);
    this.#check(this.#functions[`fmi2Get${variable.type}`](instance, this.#scratch, 1, content));
    const view = this.#view;
    if (variable.type === "Real") return view.getFloat64(content, true);
    if (variable.type === "String") return this.#textAt(this.#view.getUint32(content, true));
    const number = view.getInt32(content, true);
    return variable.type === "Boolean" ? number !== 0 : number;
  }

  /** Values of Real variables with these value references, by one call. */
  getReals(instance, references) {
    const values = this.#writeReferences(references);
    this.#check(this.#functions.fmi2GetReal(instance, this.#scratch, references.length, values));
    return new Float64Array(this.#memory, values, references.length).slice();
  }

  /** Sets Real variables by one call: all of them, or none where one value is refused. */
  setReals(instance, references, numbers) {
    const values = this.#writeReferences(references);
    new Float64Array(this.#memory, values, references.length).set(numbers);
    this.#check(this.#functions.fmi2SetReal(instance, this.#scratch, references.length, values));
  }

  /** The state of an instance as bytes. */
  save(instance) {
    const [handle, size] = [this.#scratch, this.#writeReferences([0])]; // 0: no state to write over
    this.#check(this.#functions.fmi2GetFMUstate(instance, handle));
    const state = this.#view.getUint32(handle, true);
    this.#check(this.#functions.fmi2SerializedFMUstateSize(instance, state, size));
    const bytes = this.#view.getUint32(size, true);
    const copy = this.#functions.malloc(bytes);
    this.#check(this.#functions.fmi2SerializeFMUstate(instance, state, copy, bytes));
    const saved = new Uint8Array(this.#memory, copy, bytes).slice();
    this.#functions.free(copy);
    this.#check(this.#functions.fmi2FreeFMUstate(instance, handle));
    return saved;
  }

  restore(instance, saved) {
    const handle = this.#scratch;
    const copy = this.#functions.malloc(saved.length);
    this.#writeReferences([0]);
    new Uint8Array(this.#memory).set(saved, copy);
    const read = this.#functions.fmi2DeSerializeFMUstate(instance, copy, saved.length, handle);
    this.#functions.free(copy);
    this.#check(read);
    const set = this.#functions.fmi2SetFMUstate(instance, this.#view.getUint32(handle, true));
    this.#functions.fmi2FreeFMUstate(instance, handle);
    this.#check(set);
  }
}

// ---- the engine ----

const START_ANGLE = "initial.theta"; // the parameters of the forward model that are its state at the start
const START_SPEED = "initial.omega";

/** Can this input or parameter be set while the model runs? All of these are Real. */
const isLive = (variable) => variable.causality === "input" || variable.variability === "tunable";

const ALLOWED = { Real: "a number", Integer: "a whole number", Boolean: "true or false", String: "a text" };

function isOfType(type, value) {
  if (type === "Real") return typeof value === "number";
  if (type === "Integer") return Number.isInteger(value) && Math.abs(value) < 2 ** 31;
  if (type === "Boolean") return typeof value === "boolean";
  return typeof value === "string" && !value.includes("\0");
}

/**
 * One running mechanism.
 *
 * Where a call is refused it throws a ModelError; parameters, inputs, state and time are as before the call.
 */
export class Engine {
  #library;
  #variables; // name -> Variable
  #design; // the start values that reset() brings back
  #values; // those in effect: of the design, and set since
  #instance = 0; // address of the FMU's instance
  #time = 0; // s

  /**
   * Starts the mechanism at time 0.
   * @param {BufferSource} wasm content of DualCamForward.wasm or DualCamInverse.wasm
   * @param {{guid: string, variables: Variable[]}} description of the same model, from modelDescription.xml
   * @param {Record<string, string>} files name of a groove table, as `start` has it -> its text
   * @param {Values} start start values of the design by name; the others are those of the FMU
   * @returns {Promise<Engine>}
   * @throws {ModelError} the design is refused, or WebAssembly is missing
   */
  static async create(wasm, description, files = {}, start = {}) {
    const engine = new Engine();
    engine.#library = await Library.load(wasm, description.guid, files);
    engine.#variables = new Map(description.variables.map((variable) => [variable.name, variable]));
    for (const [name, value] of Object.entries(start)) engine.#check(name, value);
    engine.#design = { ...start };
    engine.reset();
    return engine;
  }

  /** @returns {number} the time that is reached, s */
  get time() {
    return this.#time;
  }

  /**
   * The present value of a variable.
   * @param {string} name the FMU's name, or "time"
   * @returns {Value}
   */
  get(name) {
    if (name === "time") return this.#time;
    const variable = this.#find(name);
    // A restart puts the present angle and speed there: the page sees the design's.
    if (name === START_ANGLE || name === START_SPEED) return this.#values[name];
    return this.#library.get(this.#instance, variable);
  }

  /**
   * The present values of several variables, by one call for all that are Real.
   * @param {string[]} names
   * @returns {Float64Array} in the order of the names; a Boolean as 0 or 1
   */
  getAll(names) {
    const values = new Float64Array(names.length);
    const [places, references] = [[], []]; // of the Real ones
    names.forEach((name, i) => {
      const variable = name === "time" ? undefined : this.#find(name);
      if (variable?.type === "String") throw new ModelError(`${name} is a text: allowed is get("${name}")`);
      if (variable?.type === "Real" && name !== START_ANGLE && name !== START_SPEED) {
        places.push(i);
        references.push(variable.vr);
      } else values[i] = Number(this.get(name));
    });
    this.#library.getReals(this.#instance, references).forEach((value, i) => {
      values[places[i]] = value;
    });
    return values;
  }

  /**
   * Sets an input or parameter; see setAll().
   * @param {string} name
   * @param {Value} value in the FMU's unit
   */
  set(name, value) {
    const variable = this.#check(name, value);
    if (isLive(variable)) {
      this.#library.set(this.#instance, variable, value);
      this.#values[name] = value;
    } else this.setAll({ [name]: value });
  }

  /**
   * Sets inputs and parameters, all of them or none.
   *
   * Inputs and tunable parameters change at the present instant. Any other parameter starts the model anew with it:
   * time, angle and speed go on, the accounts energy.*, peak.* and events begin at 0. With initial.theta or
   * initial.omega among the parameters the model starts at these.
   * @param {Values} values
   */
  setAll(values) {
    const names = Object.keys(values);
    for (const name of names) this.#check(name, values[name]);
    if (names.every((name) => isLive(this.#find(name)))) {
      const references = names.map((name) => this.#find(name).vr);
      this.#library.setReals(this.#instance, references, Object.values(values));
      Object.assign(this.#values, values);
    } else {
      const moves = START_ANGLE in values || START_SPEED in values;
      this.#restart({ ...this.#values, ...values }, moves ? {} : this.#motion(), this.#time);
    }
  }

  /** Does a new value of the variable start the model anew? */
  startsAnew(name) {
    return !isLive(this.#find(name));
  }

  /**
   * Goes on in time, with constant inputs.
   * @param {number} seconds > 0
   */
  step(seconds) {
    this.#library.step(this.#instance, this.#time, seconds);
    this.#time += seconds;
  }

  /** Starts the page's design again, at time 0. */
  reset() {
    this.#restart({ ...this.#design }, {}, 0);
  }

  /** Starts again at time 0 with the present parameters, and the design's inputs. */
  again() {
    const values = { ...this.#values };
    for (const { name, causality, start } of this.#variables.values())
      if (causality === "input") values[name] = this.#design[name] ?? start;
    this.#restart(values, {}, 0);
  }

  /**
   * Parameters, inputs, state and time. A restored run repeats bit for bit.
   * @returns {Snapshot} which may be restored any number of times
   */
  save() {
    return { state: this.#library.save(this.#instance), values: { ...this.#values }, time: this.#time };
  }

  /** @param {Snapshot} snapshot of save() of this engine */
  restore(snapshot) {
    this.#library.restore(this.#instance, snapshot.state);
    this.#values = { ...snapshot.values };
    this.#time = snapshot.time;
  }

  /**
   * The edges of the stick band at rest, with the present parameters and F_ext.
   * @param {ArrayLike<number>} thetas angles between the end stops, rad
   * @returns {{load: Float64Array, release: Float64Array}} torque_load and torque_release, N.m
   */
  band(thetas) {
    const angle = this.#find(this.#variables.has(START_ANGLE) ? START_ANGLE : "theta");
    const speed = this.#find(this.#variables.has(START_SPEED) ? START_SPEED : "omega");
    const edges = [this.#find("torque_load").vr, this.#find("torque_release").vr];
    const [load, release] = [new Float64Array(thetas.length), new Float64Array(thetas.length)];
    const instance = this.#prepare({ ...this.#values, [speed.name]: 0 });
    try {
      for (let i = 0; i < thetas.length; i++) {
        this.#library.set(instance, angle, thetas[i]);
        [load[i], release[i]] = this.#library.getReals(instance, edges);
      }
    } finally {
      this.#library.free(instance);
    }
    return { load, release };
  }

  #find(name) {
    const variable = this.#variables.get(name);
    if (variable === undefined) throw new ModelError(`the FMU has no variable "${name}": see modelDescription.xml`);
    return variable;
  }

  /** The variable, unless the value is of another type. Whether its size is allowed, the FMU says. */
  #check(name, value) {
    const variable = this.#find(name);
    const { type, causality } = variable;
    if (causality !== "input" && causality !== "parameter") {
      throw new ModelError(`${name} is calculated: allowed are parameters and inputs`);
    }
    if (!isOfType(type, value)) throw new ModelError(`${name} = ${value} is refused: allowed is ${ALLOWED[type]}`);
    return variable;
  }

  /** The present angle and speed, as the parameters with which a new model starts there. */
  #motion() {
    if (!this.#variables.has(START_ANGLE)) return {};
    return { [START_ANGLE]: this.get("theta"), [START_SPEED]: this.get("omega") };
  }

  /** An instance with these values, before its start. */
  #prepare(values) {
    const instance = this.#library.instantiate();
    try {
      for (const [name, value] of Object.entries(values)) this.#library.set(instance, this.#find(name), value);
    } catch (error) {
      this.#library.free(instance);
      throw error;
    }
    return instance;
  }

  /** Puts a new instance in place of the present one, which stays where the new one is refused. */
  #restart(values, motion, time) {
    const instance = this.#prepare({ ...values, ...motion });
    try {
      for (const name of [START_ANGLE, START_SPEED]) {
        if (this.#variables.has(name)) values[name] ??= this.#library.get(instance, this.#find(name));
      }
      this.#library.start(instance, time);
    } catch (error) {
      this.#library.free(instance);
      if (START_ANGLE in motion && error.message.includes(START_ANGLE)) error.message += " (the present angle)";
      throw error;
    }
    if (this.#instance !== 0) this.#library.free(this.#instance);
    this.#instance = instance;
    this.#values = values;
    this.#time = time;
  }
}
