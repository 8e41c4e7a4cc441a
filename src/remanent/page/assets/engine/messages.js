/** What there is to say of a motion that is not known to its end. */

/** Why a motion ends early, in words; empty where it does not.
 *
 * @param {import("./motion.js").Motion} motion
 * @param {function(number): string} timeText a time with its symbol and unit
 * @returns {string}
 */
export function messageOf(motion, timeText) {
  const end = timeText(motion.t[motion.t.length - 1]);
  const words = {
    "left": `The motion leaves the limits of the model near ${end}.`,
    "needs shorter steps": `The motion is not followed beyond ${end}: it needs shorter steps.`,
    "differences have grown": `After ${timeText(motion.determinedUntil)} the smallest differences `
      + "have grown so much that the curve is one of many possible ones.",
    "shortened": `The motion needs ${motion.stepsPerPeriod} steps in a period; it is shown up to `
      + `${end}.`,
  };
  return words[motion.cause] ?? "";
}
