// Compares two runs of the library, from the data that the page holds. Times are judged as `ssct compare` judges them,
// number for number: with equal samples of the totals, equal seeded resamples and equal verdicts.
"use strict";
const library = JSON.parse(document.getElementById("library-data").textContent);
const name = (n) => library.names[n];

// SplitMix64's finaliser and the streams of ground/src/math/random.rs.
const MASK = (1n << 64n) - 1n, GOLDEN_GAMMA = 0x9e3779b97f4a7c15n;
const mix = (z) => {
  z = ((z ^ (z >> 30n)) * 0xbf58476d1ce4e5b9n) & MASK;
  z = ((z ^ (z >> 27n)) * 0x94d049bb133111ebn) & MASK;
  return z ^ (z >> 31n);
};
const streamOf = (seed, index) => mix((mix((seed + GOLDEN_GAMMA) & MASK) + index * GOLDEN_GAMMA) & MASK);
const uniform = (stream, position) =>
  Number(mix((stream + (position + 1n) * GOLDEN_GAMMA) & MASK) >> 11n) / 2 ** 53;

// The random numbers of each resample, made as they are needed; they are equal for all subjects.
const streams = [], numbers = [];
const randomNumber = (resample, position) => {
  if (!(resample in streams)) {
    streams[resample] = streamOf(BigInt(library.seed), BigInt(resample));
    numbers[resample] = [];
  }
  while (numbers[resample].length <= position) {
    numbers[resample].push(uniform(streams[resample], BigInt(numbers[resample].length)));
  }
  return numbers[resample][position];
};

const median = (samples) => {
  samples.sort((a, b) => a - b);
  return (samples[(samples.length - 1) >> 1] + samples[samples.length >> 1]) / 2;
};
// b over a; 1 if both are 0.
const quotient = (a, b) => (a === b ? 1 : b / a);
const percentile = (sorted, share) => sorted[Math.max(Math.ceil(share * sorted.length), 1) - 1];

// Returns B's median over A's, and the bounds of the interval of the resamples, as in lab/truth/src/metrics/bootstrap.rs.
// `a` and `b` are times in milliseconds.
function ratioOfMedians(a, b) {
  const ratios = [];
  for (let resample = 0; resample < library.resamples; resample++) {
    let position = 0;
    const resampled = (samples) =>
      samples.map(() =>
        samples[Math.min(Math.floor(randomNumber(resample, position++) * samples.length), samples.length - 1)]);
    const medianA = median(resampled(a));
    ratios.push(quotient(medianA, median(resampled(b))));
  }
  ratios.sort((x, y) => x - y);
  const tail = (1 - library.confidence) / 2;
  const ratio = quotient(median([...a]), median([...b]));
  return { ratio, low: percentile(ratios, tail), high: percentile(ratios, 1 - tail) };
}

function verdict({ low, high }, threshold, floor) {
  const bound = Math.max(threshold, floor);
  if (high < 1 - bound) return "FASTER";
  if (low > 1 + bound) return "SLOWER";
  return low >= 1 - threshold && high <= 1 + threshold ? "SAME" : "UNDECIDED";
}

// Groups a run's frames by subject. A setting that the other run's file does not state for the method is left out, so that
// subjects which differ in this setting alone become one group. The settings of a sample are pairs of indices into `names`.
function groups(samples, other) {
  const method = (settings) => name((settings.find(([n]) => name(n) === "method") ?? [])[1]);
  // For each method, the names of the settings that the other run states.
  const statedNames = new Map();
  for (const [settings] of other) {
    const names = statedNames.get(method(settings)) ?? new Set();
    settings.forEach(([n]) => names.add(n));
    statedNames.set(method(settings), names);
  }
  const found = new Map();
  for (const [settings, labels, floor, ms] of samples) {
    const names = statedNames.get(method(settings));
    const key = settings.filter(([n]) => !names || names.has(n)).map((pair) => pair.join("=")).sort().join(" ");
    const group = found.get(key);
    if (group) group.ms.push(...ms);
    else found.set(key, { labels, floor, ms: [...ms] });
  }
  return found;
}

// Returns the rows of the table of times: for each subject of both runs, the medians, their ratio with its interval, and
// the verdict.
function times(a, b) {
  const [groupsA, groupsB] = [groups(a.samples, b.samples), groups(b.samples, a.samples)];
  const rows = [];
  for (const [key, groupA] of groupsA) {
    const groupB = groupsB.get(key);
    if (!groupB) continue;
    const found = ratioOfMedians(groupA.ms, groupB.ms);
    const floor = Math.max(groupA.floor ?? 0, groupB.floor ?? 0);
    const hasEnough = Math.min(groupA.ms.length, groupB.ms.length) >= library.minSamples;
    const figures = [median([...groupA.ms]), median([...groupB.ms]), found.ratio, found.low, found.high];
    rows.push([...groupA.labels.map(name), ...figures.map((v) => v.toFixed(3)),
      `${groupA.ms.length}/${groupB.ms.length}`, hasEnough ? verdict(found, library.threshold, floor) : "UNDECIDED"]);
  }
  return rows;
}

// Compares the figures that both runs have: returns how many there are, how many differ, and the rows of the 200 that
// differ most. A figure is an array of place, setting, method and title, as indices, and of its value.
function errors(a, b) {
  const key = (figure) => figure.slice(0, 4).join(" ");
  const valuesA = new Map(a.figures.map((figure) => [key(figure), figure[4]]));
  const both = b.figures.filter((figure) => valuesA.has(key(figure)));
  const changed = both.map((figure) => ({ figure, from: valuesA.get(key(figure)), to: figure[4] }))
    .filter(({ from, to }) => from !== to);
  const change = ({ from, to }) => Math.abs(Math.log(Math.max(to, 1e-12) / Math.max(from, 1e-12)));
  changed.sort((x, y) => change(y) - change(x));
  const shown = (v) => (v === 0 || v >= 1e-3 ? v.toFixed(6) : v.toExponential(3));
  const row = ({ figure: [place, , method, what], from, to }) =>
    [name(place), name(method), name(what), shown(from), shown(to), from > 0 ? (to / from).toFixed(4) : "-"];
  return { both: both.length, changed: changed.length, rows: changed.slice(0, 200).map(row) };
}

const element = (tag, text) => Object.assign(document.createElement(tag), { textContent: text });

function table(header, rows) {
  const made = document.createElement("table"), scroll = document.createElement("div");
  const line = (cells, first) => {
    const tr = document.createElement("tr");
    cells.forEach((cell, n) => tr.append(element(first || n === 0 ? "th" : "td", cell)));
    return tr;
  };
  const head = made.createTHead(), body = made.createTBody();
  head.append(line(header, true));
  rows.forEach((row) => body.append(line(row, false)));
  scroll.className = "scroll";
  scroll.append(made);
  return scroll;
}

const [selectA, selectB] = [document.getElementById("run-a"), document.getElementById("run-b")];

function say(id, ...parts) {
  document.getElementById(id).replaceChildren(...parts);
}

function show() {
  const [a, b] = [selectA, selectB].map((select) => library.runs[select.value]);
  const on = (run) => run.devices.map((d) => `D${d + 1}, ${library.devices[d]}`).join("; ");
  const command = [element("code", `ssct compare ${a.name} ${b.name}`), " says the same of every pass."];
  say("about-runs", `A ran on ${on(a)}. B ran on ${on(b)}. `, ...(a.samples && b.samples ? command : []));
  const lacks = [["A", a], ["B", b]].filter(([, run]) => !run.samples).map(([side]) => side).join(" and ");
  if (lacks) {
    say("compared-times", element("p", `Not compared: no raw samples of times lie beside the records of ${lacks}.`));
  } else if (a.samplesDevice === null || a.samplesDevice !== b.samplesDevice) {
    say("compared-times", element("p", "Not compared: times compare only on one device."));
  } else {
    const rows = times(a, b);
    const header = [...library.columns, "A ms", "B ms", "B/A", "low", "high", "n", "verdict"];
    say("compared-times", rows.length ? table(header, rows) : element("p", "The two runs timed nothing in common."));
  }
  const found = errors(a, b);
  const more = found.changed > found.rows.length ? `; the ${found.rows.length} that changed most` : "";
  const text = `${found.both} figures are of the same place, setting and method in both runs; ` +
    `${found.changed} of them differ${more}. An error does not depend on the speed of a device.`;
  const header = ["place", "method", "figure", "A", "B", "B/A"];
  say("compared-errors", element("p", found.both ? text : "The two runs have no error in common."),
    ...(found.rows.length ? [table(header, found.rows)] : []));
}

if (library.runs.length > 1) {
  for (const select of [selectA, selectB]) {
    library.runs.forEach((run, n) => select.add(new Option(`${n + 1}. ${run.date} ${run.name}`, n)));
    select.addEventListener("change", show);
  }
  [selectA.value, selectB.value] = library.first ?? [library.runs.length - 2, library.runs.length - 1];
  document.getElementById("choose-runs").hidden = false;
  show();
}
