// The tables of a study file, and the numbers in them that sliders move.

/**
 * The tables with other numbers in them.
 * @param {Object} description of the model: `spec`, `parameters`, `state`
 * @param {Object<string, number>} values of parameters by name
 * @param {ArrayLike<number>} initial value of each state variable
 * @returns {Object} new tables
 */
export function specWith(description, values, initial) {
  const spec = structuredClone(description.spec);
  for (const parameter of description.parameters) {
    if (values[parameter.name] !== parameter.value) {
      put(spec, parameter, values[parameter.name]);
    }
  }
  const started = description.state.filter((one, k) => initial[k] !== restOf(one, values));
  delete spec.initial;
  if (started.length) {
    spec.initial = Object.fromEntries(
      description.state.map((one, k) => [one.name, initial[k]]),
    );
  }
  return spec;
}

/**
 * The value of a state variable at rest.
 * @param {{rest: number|string}} variable
 * @param {Object<string, number>} values of parameters
 * @returns {number}
 */
export function restOf(variable, values) {
  return typeof variable.rest === "string" ? values[variable.rest] : variable.rest;
}

function put(spec, { name, group }, value) {
  if (group === "system") {
    const table = spec.system;
    table.parameters = { ...table.parameters, [name]: value };
    return;
  }
  const table = group === "drive" ? spec.drive : spec.actuator;
  if (table.si && (name === "c" || name === "edges_2")) {
    const half = parseFloat(table.si.half_length);
    const key = name === "c" ? "half_thickness" : "half_width";
    table.si[key] = `${(name === "c" ? Math.sqrt(value) : value) * half} m`;
    return;
  }
  const pair = /^(prestress|edges)_([12])$/.exec(name);
  putAt(table, pair ? [pair[1], Number(pair[2]) - 1] : name.split("."), value);
}

function putAt(table, steps, value) {
  const last = steps.length - 1;
  let here = table;
  for (let k = 0; k < last; k += 1) {
    here = here[steps[k]] ??= {};
  }
  here[steps[last]] = value;
}
