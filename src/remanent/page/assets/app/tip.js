// The words beside the pointer.

/**
 * Show words beside a place of a figure; hide them where there are none.
 * @param {Object} plot
 * @param {string} text
 * @param {?{px: number, py: number}} place
 */
export function placeTip(plot, text, place) {
  const { tip, host } = plot;
  tip.hidden = !text || !place;
  if (tip.hidden) {
    return;
  }
  tip.textContent = text;
  const left = Math.min(place.px + 14, host.clientWidth - tip.offsetWidth - 4);
  const top = place.py > host.clientHeight / 2 ? place.py - tip.offsetHeight - 10 : place.py + 14;
  tip.style.transform = `translate(${Math.max(4, left)}px, ${Math.max(2, top)}px)`;
}
