// Carries out the commands of a scene (view_scenes.py) on something with set, get, step and reset: the Engine of
// dualcam/view/engine.js in node, or window.dualcam in a browser.

export function drive(target, commands, names) {
  const results = [];
  let saved;
  const actions = {
    set: (name, value) => target.set(name, value),
    step: (seconds) => target.step(seconds),
    reset: () => target.reset(),
    read: () => results.push(names.map((name) => Number(target.get(name)))),
    get: (name) => results.push(target.get(name)),
    save: () => (saved = target.save()),
    restore: () => target.restore(saved),
    band: (thetas) => {
      const { load, release } = target.band(thetas);
      results.push([...load, ...release]);
    },
  };
  for (const [action, ...operands] of commands) {
    try {
      actions[action](...operands);
    } catch (error) {
      if (error.name !== "ModelError") throw error;
      results.push({ refused: error.message });
    }
  }
  return results;
}
