/** window.dualcam: the model for scripts and tests, with the FMU's names and units. */

/**
 * @param {Promise<import("dualcam/player").Player>} started
 * @param {{takeOver: () => void, refresh: (kind: string) => void, choose: (name: string) => Promise<void>}} page
 */
export function giveAccess(started, page) {
  let player = null;
  const scripted = started.then((it) => {
    player = it;
  });
  const model = () => {
    if (player === null) throw new Error("the model is not ready: await dualcam.ready first");
    page.takeOver();
    return player;
  };
  const access = {
    /** Resolves when a script may step. The page's own clock rests from then on, until somebody presses Play. */
    get ready() {
      return scripted.then(() => {
        page.takeOver();
      });
    },
    /** The design's start values, at time 0. */
    reset() {
      model().toDesign();
    },
    /** Sets an input or a parameter. An Error names a variable that does not exist, or says why a value is refused. */
    set(name, value) {
      const it = model();
      it.engine.set(name, value);
      page.refresh(it.scripted(name));
    },
    /** The present value of any variable, or "time". */
    get(name) {
      if (player === null) throw new Error("the model is not ready: await dualcam.ready first");
      return player.engine.get(name);
    },
    /** One step of the FMU with constant inputs. */
    step(seconds) {
      const it = model();
      it.engine.step(seconds);
      it.record();
      page.refresh("step");
    },
    /** Chooses a scene by the word on its button; its clock rests. */
    async choose(name) {
      await scripted;
      page.takeOver();
      await page.choose(name);
      player.pause();
    },
    /** Lets the page's clock run for a time of the model at once, with the torque of the scene. */
    run(seconds) {
      const it = model();
      it.run(seconds);
      page.refresh("step");
    },
  };
  Object.defineProperty(window, "dualcam", { value: Object.freeze(access) });
}
