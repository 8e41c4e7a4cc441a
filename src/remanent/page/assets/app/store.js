// The state of the page: what is looked at, and who wants to know when it changes.

/**
 * A store of one plain object.
 * @param {Object} initial
 * @returns {{get: function(): Object, update: function(Object): void,
 *   subscribe: function(function(Object, Object): void): void}}
 *   subscribers are called with the new state and what was changed
 */
export function createStore(initial) {
  let state = initial;
  const subscribers = new Set();
  return {
    get: () => state,
    update: (change) => {
      state = { ...state, ...change };
      subscribers.forEach((subscriber) => subscriber(state, change));
    },
    subscribe: (subscriber) => subscribers.add(subscriber),
  };
}
