/**
 * Scenes: parameters of a mechanism, torque over time, and what one sees.
 *
 * Values that a scene does not name are the FMU's start values.
 */

const SMOOTH = { "shaft.damping": 0.04 };

/** The scenes of every page. */
export const PRESETS = [
  {
    name: "Load",
    words: "The torque rises. Above the stick band cam 2 follows, and the spring takes up the work.",
    start: SMOOTH,
    histories: { tau: { time: [0, 0.3, 2.3], value: [0, 0, 8] } },
    seconds: 3,
  },
  {
    name: "Release",
    words: "The torque falls. Cam 2 stands still through the whole stick band, and then the spring turns cam 2 back.",
    start: { ...SMOOTH, "initial.theta": 1.2, tau: 7 },
    histories: { tau: { time: [0, 0.3, 3.3], value: [7, 7, 0] } },
    seconds: 3.6,
  },
  {
    name: "Self-lock",
    words: "Flat grooves of 6 deg. Without any torque the loaded mechanism stands; only a negative torque brings it back.",
    start: { ...SMOOTH, "cam1.lead_angle": 0.1047, "cam2.lead_angle": 0.1047, "spring.stiffness": 500000, "initial.theta": 1.2 },
    histories: { tau: { time: [0, 1.5, 3.5], value: [0, 0, -0.6] } },
    seconds: 4,
  },
  {
    name: "Wedge",
    words: "Very flat grooves of unequal radii wedge the pin: the largest negative torque moves nothing.",
    start: {
      ...SMOOTH, "cam1.radius": 0.06, "cam2.radius": 0.02, "cam1.lead_angle": 0.01, "cam2.lead_angle": 0.15,
      "initial.theta": 0.8,
    },
    histories: { tau: { time: [0, 0.5, 3], value: [0, 0, -1] } },
    seconds: 3.2,
  },
  {
    name: "Stop",
    words: "A torque of 14 N.m drives cam 2 against the upper end stop. Cam 2 bounces, and then rests at the stop.",
    start: { "stop.restitution": 0.6 },
    histories: { tau: { time: [0, 0.2, 0.2], value: [0, 0, 14] } },
    seconds: 1.5,
    speed: 0.1,
  },
  {
    name: "Stick-slip",
    words: "A soft shaft pulls slowly, and friction is larger at rest than in motion: cam 2 sticks and slips in turn.",
    start: {
      "shaft.damping": 0.02, "inertia.shaft": 0.004, "cam1.friction_peak": 2, "cam2.friction_peak": 2,
      "cam1.stribeck_velocity": 0.01, "cam2.stribeck_velocity": 0.01,
    },
    drive: { stiffness: 20, speed: 0.5, until: 4 },
    seconds: 4.2,
  },
];

/** The scene of the design itself: its scenario, or a slow turn through its stick band. */
export function designScene(content, player) {
  if (content.scenario) {
    const { time, ...inputs } = content.scenario;
    const histories = Object.fromEntries(Object.entries(inputs).map(([name, value]) => [name, { time, value }]));
    return { name: "Design", words: "The scenario of the design file.", histories, seconds: time[time.length - 1] };
  }
  const most = 1.15 * player.torqueScale;
  const least = Math.min(0, -0.3 * most * Number(player.engine.get("torque_release") < 0));
  return {
    name: content.source ? "Design" : "Turn",
    words: "A slow torque up and down: cam 2 turns, stands still through the stick band, and comes back.",
    histories: { tau: { time: [0, 2.5, 3.2, 6], value: [0, most, most, least] } },
    seconds: 6.2,
  };
}
