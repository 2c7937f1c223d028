(async () => {
  const { byId, numbers, heading, unmarked, short, row, options, embed, ink, paintAxes, painted } = page;
  const data = JSON.parse(byId("data").textContent);
  const model = await embed(data.document);
  const painters = [];

  const edges = (values) => {
    const middles = values.slice(1).map((each, k) => (each + values[k]) / 2);
    const width = values.length > 1 ? values[1] - values[0] : Math.abs(values[0]) || 1;
    const last = values.length > 1 ? values.at(-1) - values.at(-2) : width;
    return [values[0] - width / 2, ...middles, values.at(-1) + last / 2];
  };
  // of numbers in their order, between the two that are nearest
  const quantile = (sorted, part) => {
    const place = part * (sorted.length - 1);
    const below = Math.floor(place);
    const above = Math.min(below + 1, sorted.length - 1);
    return sorted[below] + (place - below) * (sorted[above] - sorted[below]);
  };
  // one by one, as a call takes no more than some 100,000 arguments
  const add = (extent, ...lists) => lists.forEach((values) => values.forEach((value) => extent.push(value)));
  const finite = (values) => Array.from(values).filter(Number.isFinite).sort((a, b) => a - b);
  const STATISTICS = [
    ["median", (sorted) => quantile(sorted, 0.5)],
    ["10 % quantile", (sorted) => quantile(sorted, 0.1)],
    ["90 % quantile", (sorted) => quantile(sorted, 0.9)],
    ["mean", (sorted) => sorted.reduce((sum, each) => sum + each, 0) / sorted.length],
  ];
  const mean = STATISTICS[3][1];
  const span = (range, start, end) => range.setv({ start, end, reset_start: start, reset_end: end });
  // so that all numbers fit in, with a margin
  const fit = (range, values) => {
    const [low, high] = values.filter(Number.isFinite).reduce(
      ([least, most], value) => [Math.min(least, value), Math.max(most, value)], [Infinity, -Infinity]);
    const margin = 0.05 * (high - low) || 0.05 * Math.abs(high) || 0.5;
    if (low <= high) span(range, low - margin, high + margin);
    else span(range, 0, 1);
  };

  data.groups.forEach((group, place) => {
    const id = (name) => byId(`${name}-${place}`);
    const sweeps = group.names.map((_, sweep) => sweep);
    const several = sweeps.length > 1;
    const sampled = group.count > 0;
    const dimensions = group.axes.length;
    const each = sampled ? group.count : 1;
    const sizes = group.axes.map((axis) => axis.texts.length);
    const places = group.axes.map((axis) => axis.values ?? axis.texts.map((_, k) => k));
    const measures = group.measures.map((measure) => ({ ...measure, data: measure.values.map(numbers) }));
    const unstable = measures.findIndex((measure) => measure.name === "unstable");
    // of samples the state of a point is a probability
    if (sampled && unstable >= 0) {
      Object.assign(measures[unstable], { name: "probability", label: "probability of stick-slip", low: 0, high: 1 });
      measures.unshift(measures.splice(unstable, 1)[0]);
    }
    const state = measures.find((measure) => ["unstable", "probability"].includes(measure.name));
    const panels = sampled ? measures : measures.filter((measure) => measure !== state);
    const cursor = sizes.map((size) => Math.floor((size - 1) / 2));
    let plane = dimensions > 1 ? preferred() : [0];
    const dropped = new Set();

    // drive speed across and weight on bit up, if both vary; else as they come
    function preferred() {
      const find = (end) => group.axes.findIndex((axis) => axis.name.endsWith(end));
      const [speed, weight] = [find(".Omega"), find(".WOB")];
      return speed >= 0 && weight >= 0 ? [speed, weight] : [0, 1];
    }
    const indexOf = (point) => point.reduce((sum, k, axis) => sum * sizes[axis] + k, 0);
    const samplesAt = (measure, sweep, index) => measure.data[sweep].subarray(index * each, (index + 1) * each);
    const statistic = () => Number(id("statistic")?.value ?? 0);
    const valueAt = (measure, sweep, index, which = statistic()) => {
      if (!sampled) return measure.data[sweep][index];
      const known = finite(samplesAt(measure, sweep, index));
      if (!known.length) return NaN;
      return measure === state ? mean(known) : STATISTICS[which][1](known);
    };
    const shown = () => measures[Number(id("measure").value)];
    const subtracted = () => (several && dimensions > 1 ? Number(id("less").value) - 1 : -1);
    const texts = (point) => group.axes.map((axis, k) => `${axis.name} ${axis.texts[point[k]]} ${axis.unit}`.trim());

    const ticks = (axis, told) => {
      axis.axis_label = unmarked(heading(told));
      if (told.values === null) {
        const FixedTicker = Bokeh.Models.get("FixedTicker");
        axis.setv({
          ticker: new FixedTicker({ ticks: told.texts.map((_, k) => k), minor_ticks: [] }),
          major_label_overrides: new Map(told.texts.map((text, k) => [k, unmarked(text)])),
        });
      }
    };

    // ---- maps of the plane through the cursor
    const cellsOf = () => {
      const [ax, ay] = plane;
      const found = [];
      places[ay].forEach((_, j) => places[ax].forEach((__, i) => {
        const point = [...cursor];
        point[ax] = i;
        point[ay] = j;
        found.push(indexOf(point));
      }));
      return found;
    };
    const drawAxes = () => {
      const [ax, ay] = plane;
      const [ex, ey] = [edges(places[ax]), edges(places[ay])];
      span(model(`x-range-${place}`), ex[0], ex.at(-1));
      span(model(`y-range-${place}`), ey[0], ey.at(-1));
      for (const sweep of sweeps) {
        const figure = model(`map-${place}-${sweep}`);
        ticks(figure.below[0], group.axes[ax]);
        ticks(figure.left[0], group.axes[ay]);
      }
    };
    const drawMaps = () => {
      const [ax, ay] = plane;
      const [ex, ey] = [edges(places[ax]), edges(places[ay])];
      const measure = shown();
      const less = subtracted();
      const cells = cellsOf();
      const width = places[ax].length;
      const corners = {
        left: cells.map((_, k) => ex[k % width]), right: cells.map((_, k) => ex[(k % width) + 1]),
        bottom: cells.map((_, k) => ey[Math.floor(k / width)]), top: cells.map((_, k) => ey[Math.floor(k / width) + 1]),
      };
      const middle = (picked) => ({
        x: picked.map((k) => places[ax][k % width]), y: picked.map((k) => places[ay][Math.floor(k / width)]),
      });
      const drawn = sweeps.map((sweep) => cells.map((index) => valueAt(measure, sweep, index)
        - (less >= 0 ? valueAt(measure, less, index) : 0)));
      const whole = (sweep, index) => Number.isFinite(valueAt(state, sweep, index, 0));
      const apart = several && state ? cells.flatMap((index, k) => {
        const states = sweeps.map((sweep) => valueAt(state, sweep, index, 0) > 0.5);
        return sweeps.every((sweep) => whole(sweep, index)) && states.includes(true) && states.includes(false) ? [k] : [];
      }) : [];
      let [low, high] = [measure.low, measure.high];
      if (less >= 0) {
        const most = drawn.flat().filter(Number.isFinite).reduce((most, value) => Math.max(most, Math.abs(value)), 0);
        high = Math.min(most || 1, measure.name === "ssi" ? measure.high : Infinity);
        low = -high;
      }
      const palette = data.palettes[less >= 0 ? "difference" : measure.palette];
      for (const sweep of sweeps) {
        const key = `${place}-${sweep}`;
        model(`colours-${key}`).setv({ low, high, palette });
        model(`cells-${key}`).data = { ...corners, value: drawn[sweep] };
        // dots that leave the colour of their cells to be seen; what stands beside a map is 140 pixels wide, 60 high
        const room = [(byId(`map-${key}`).clientWidth - 140) / width, (byId(`map-${key}`).clientHeight - 60) / places[ay].length];
        model(`dots-${key}`).glyph.size = { value: Math.min(5, Math.max(1, 0.45 * Math.min(...room))) };
        model(`apart-${key}`).data = middle(less >= 0 ? [] : apart);
        const failed = new Set(group.failed[sweep].map((index) => Math.floor(index / each)));
        const lost = cells.flatMap((index, k) => (failed.has(index) && !Number.isFinite(drawn[sweep][k]) ? [k] : []));
        model(`failed-${key}`).data = middle(lost);
        const [across, up] = ringsOf(sweep) ?? [[], []];
        model(`rings-${key}`).data = { x: up.flatMap(() => across), y: up.flatMap((value) => across.map(() => value)) };
        for (const kind of ["threshold", "fold"]) {
          const line = group.lines[sweep].find((told) => told.kind === kind
            && [...told.plane].sort().join() === [...plane].sort().join()
            && Object.entries(told.at).every(([axis, k]) => cursor[axis] === k));
          const [x, y] = line ? [numbers(line.x), numbers(line.y)] : [[], []];
          model(`${kind}-${key}`).data = line && line.plane[0] !== plane[0] ? { x: y, y: x } : { x, y };
        }
      }
      const word = several && state ? `; ${apart.length} cells in which the sweeps disagree` : "";
      const what = `${heading(measure)}${measure.label ? `, ${measure.label}` : ""}`;
      const others = texts(cursor).filter((_, axis) => !plane.includes(axis));
      sweeps.forEach((sweep) => {
        const minus = less >= 0 ? `, less ${group.names[less]}` : "";
        const at = others.length ? `, at ${others.join(", ")}` : "";
        const of = sampled && measure !== state ? `${STATISTICS[statistic()][0]} of ` : "";
        byId(`caption-${place}-${sweep}`).textContent = `${group.names[sweep]}${minus}: ${of}${what}${at}${word}`;
      });
    };
    const drawCursor = () => {
      const [ax, ay] = plane;
      const [ex, ey] = [edges(places[ax]), edges(places[ay])];
      const [i, j] = [cursor[ax], cursor[ay]];
      for (const sweep of sweeps) {
        model(`cursor-${place}-${sweep}`).data = { left: [ex[i]], right: [ex[i + 1]], bottom: [ey[j]], top: [ey[j + 1]] };
      }
    };

    // ---- lines over one axis
    const drawLines = () => {
      const ends = edges(places[0]);
      span(model(`x-range-${place}`), ends[0], ends.at(-1));
      model(`strips-${place}`).data = { left: ends.slice(0, -1), right: ends.slice(1) };
      panels.forEach((measure, k) => {
        const figure = model(`line-${place}-${k}`);
        const extent = [];
        figure.left[0].axis_label = unmarked(heading(measure));
        ticks(figure.below[0], group.axes[0]);
        for (const sweep of sweeps) {
          const at = (which) => places[0].map((_, i) => valueAt(measure, sweep, i, which));
          const y = at(0);
          const banded = sampled && measure !== state;
          const [low, high] = banded ? [at(1), at(2)] : [y, y];
          model(`curve-${place}-${k}-${sweep}`).data = { x: places[0], y, low, high };
          if (!dropped.has(sweep)) add(extent, low, high);
          const ringed = (ringsOf(sweep) ?? [[]])[0].filter((value) => places[0].includes(value));
          model(`rings-${place}-${k}-${sweep}`).data = { x: ringed, y: ringed.map((value) => y[places[0].indexOf(value)]) };
          model(`ring-${place}-${k}-${sweep}`).visible = !dropped.has(sweep);
          model(`stroke-${place}-${k}-${sweep}`).visible = group.axes[0].values !== null && !dropped.has(sweep);
          model(`dot-${place}-${k}-${sweep}`).visible = (places[0].length <= 200) && !dropped.has(sweep);
          if (sampled) model(`band-${place}-${k}-${sweep}`).visible = banded && !dropped.has(sweep);
        }
        fit(figure.y_range, extent);
        const of = sampled && measure !== state ? "median of the samples, and band from the 10 % to the 90 % quantile, of " : "";
        const names = group.names.filter((_, sweep) => !dropped.has(sweep)).join(", ");
        byId(`caption-${place}-line-${k}`).textContent = `${of}${heading(measure)}`
          + `${measure.label ? `, ${measure.label},` : ""} over ${heading(group.axes[0])}${several ? `: ${names}` : ""}`;
      });
    };

    // ---- samples at the cursor
    const drawSamples = () => {
      const measure = shown() === state ? measures[Math.min(1, measures.length - 1)] : shown();
      const index = indexOf(cursor);
      const input = group.samples[Number(id("sampled").value)];
      const x = numbers(input.values);
      const extent = [];
      model(`ecdf-${place}`).below[0].axis_label = unmarked(heading(measure));
      model(`scatter-${place}`).below[0].axis_label = unmarked(heading(input));
      model(`scatter-${place}`).left[0].axis_label = unmarked(heading(measure));
      for (const sweep of sweeps) {
        const values = samplesAt(measure, sweep, index);
        const sorted = finite(values);
        model(`ecdf-${place}-${sweep}`).data = {
          x: sorted.length ? [sorted[0], ...sorted] : [], y: sorted.length ? [0, ...sorted.map((_, k) => (k + 1) / sorted.length)] : [],
        };
        model(`scatter-${place}-${sweep}`).data = { x, y: Array.from(values) };
        if (!dropped.has(sweep)) add(extent, sorted);
        for (const name of ["stair", "spot"]) model(`${name}-${place}-${sweep}`).visible = !dropped.has(sweep);
      }
      fit(model(`ecdf-${place}`).x_range, extent);
      span(model(`ecdf-${place}`).y_range, -0.02, 1.02);
      fit(model(`scatter-${place}`).x_range, Array.from(x));
      fit(model(`scatter-${place}`).y_range, extent);
      const where = dimensions ? ` at ${texts(cursor).join(", ")}` : "";
      id("caption-ecdf").textContent = `Distribution of ${heading(measure)} among the samples${where}: part of them up to each value`;
      id("caption-scatter").textContent = `${heading(measure)} of each sample${where} over ${heading(input)}`;
    };

    // ---- what was kept over time, of the point at the cursor or of the nearest one
    const signals = [];
    for (const series of group.series) {
      for (const signal of series ? series.signals : []) {
        if (!signals.some((known) => known.name === signal.name)) signals.push(signal);
      }
    }
    const traces = signals.slice(0, 4).map((_, k) => k);
    const kept = group.series.map((series) => series?.axes.map((axis) => axis.values ?? axis.texts.map((_, k) => k)));
    const nearest = (values, value) => values.reduce(
      (best, each, k) => (Math.abs(each - value) < Math.abs(values[best] - value) ? k : best), 0);
    const keptAt = (sweep) => {
      if (!group.series[sweep]) return null;
      const near = kept[sweep].map((values, axis) => nearest(values, places[axis][cursor[axis]]));
      const same = near.every((k, axis) => kept[sweep][axis][k] === places[axis][cursor[axis]]);
      const index = near.reduce((sum, k, axis) => sum * kept[sweep][axis].length + k, 0);
      return { near, same, index };
    };
    const drawSeries = () => {
      const found = sweeps.map(keptAt);
      traces.forEach((chosen, panel) => {
        const signal = signals[chosen];
        const figure = model(`series-${place}-${panel}`);
        const extent = [];
        figure.left[0].axis_label = unmarked(heading(signal));
        for (const sweep of sweeps) {
          const series = group.series[sweep];
          const number = series ? series.signals.findIndex((each) => each.name === signal.name) : -1;
          const line = number < 0 ? null : series.lines[number][found[sweep].index];
          const quantiles = line?.quantiles?.map(numbers);
          const x = line ? numbers(line.x) : [];
          const y = quantiles ? quantiles[2] : line ? numbers(line.y) : [];
          const [q0, q1, , q3, q4] = quantiles ?? [y, y, y, y, y];
          model(`signal-${place}-${panel}-${sweep}`).data = { x, y, q0, q1, q3, q4 };
          for (const name of sampled ? ["trace", "q0", "q1"] : ["trace"]) {
            model(`${name}-${place}-${panel}-${sweep}`).visible = !dropped.has(sweep);
          }
          if (!dropped.has(sweep)) add(extent, q0, q4);
        }
        fit(figure.y_range, extent);
        const of = sampled ? "median of the samples, with bands from the 25 % to the 75 % and from the 5 % to the 95 % quantile, of " : "";
        const names = group.names.filter((_, sweep) => found[sweep] && !dropped.has(sweep)).join(", ");
        byId(`caption-${place}-series-${panel}`).textContent = `${of}${heading(signal)} over time${several ? `: ${names}` : ""}`;
      });
      const said = new Map();
      sweeps.forEach((sweep) => {
        if (!found[sweep]) {
          said.set(`${group.names[sweep]} has kept nothing over time.`, []);
          return;
        }
        const series = group.series[sweep];
        const where = series.axes.map((axis, k) => `${axis.name} ${axis.texts[found[sweep].near[k]]} ${axis.unit}`.trim());
        const message = series.messages[found[sweep].index];
        const what = `${!dimensions ? "Of all samples." : found[sweep].same ? `Of the point at the cursor, ${where.join(", ")}.`
          : `Nothing is kept of the point at the cursor; of the nearest that is, ${where.join(", ")}.`}${message ? ` ${message}` : ""}`;
        said.set(what, [...(said.get(what) ?? []), group.names[sweep]]);
      });
      id("kept").textContent = [...said].map(([what, names]) => (
        said.size > 1 && names.length ? `${names.join(", ")}: ${what}` : what)).join(" ");
    };
    // where something is kept
    const ringsOf = (sweep) => {
      if (!group.series[sweep]) return null;
      const others = cursor.map((k, axis) => axis).filter((axis) => !plane.includes(axis));
      if (!others.every((axis) => kept[sweep][axis].includes(places[axis][cursor[axis]]))) return null;
      return plane.map((axis) => kept[sweep][axis]);
    };

    // ---- the cursor
    const tabulate = () => {
      const index = dimensions ? indexOf(cursor) : 0;
      const cells = (measure) => sweeps.map((sweep) => {
        if (!sampled || measure === state) return short(valueAt(measure, sweep, index, 0));
        const [middle, low, high] = [0, 1, 2].map((which) => short(valueAt(measure, sweep, index, which)));
        return middle === "-" ? "-" : `${middle} (${low} to ${high})`;
      });
      id("values").replaceChildren(...measures.map((measure) => row(heading(measure), cells(measure))));
      const where = dimensions ? texts(cursor).join(", ") : "all samples";
      id("point").textContent = `${dimensions ? "Point at the cursor" : "Over"}: ${where}`
        + `${sampled ? "; median of the samples, and from the 10 % to the 90 % quantile" : ""}`;
      return where;
    };
    const point = () => {
      group.axes.forEach((_, axis) => { byId(`at-${place}-${axis}`).value = cursor[axis]; });
      const where = tabulate();
      if (dimensions > 1) drawCursor();
      if (dimensions === 1) panels.forEach((_, k) => { model(`here-${place}-${k}`).location = places[0][cursor[0]]; });
      if (sampled) drawSamples();
      if (signals.length) drawSeries();
      byId("status").textContent = `Cursor at ${where}.`;
    };
    const draw = () => {
      if (dimensions > 1) drawMaps();
      if (dimensions === 1) drawLines();
      if (sampled) drawSamples();
      if (signals.length) drawSeries();
    };

    // ---- controls
    if (signals.length) {
      // where something is kept, so that this is what is seen first
      const first = keptAt(group.series.findIndex((series) => series));
      const axes = kept.find((values) => values);
      first.near.forEach((k, axis) => { cursor[axis] = Math.max(0, places[axis].indexOf(axes[axis][k])); });
      const ends = group.series.filter((series) => series).map((series) => series.end);
      span(model(`time-range-${place}`), Math.min(...ends.map((end) => end[0])), Math.max(...ends.map((end) => end[1])));
      traces.forEach((chosen, panel) => {
        const choice = byId(`signal-${place}-${panel}`);
        choice.append(...options(signals.map(heading)));
        choice.value = chosen;
        choice.addEventListener("change", () => {
          traces[panel] = Number(choice.value);
          drawSeries();
        });
      });
    }
    const listen = (element, act) => element?.addEventListener("change", act);
    id("measure")?.append(...options(measures.map((measure) => (
      measure.label && measure !== state ? `${heading(measure)}: ${measure.label}` : heading(measure)))));
    const start = measures.findIndex((measure) => measure.name === (sampled && dimensions ? "probability" : "ssi"));
    if (id("measure")) id("measure").value = Math.max(0, start);
    if (sampled) {
      id("statistic")?.append(...options(STATISTICS.map(([name]) => name)));
      id("sampled").append(...options(group.samples.map(heading)));
      listen(id("sampled"), drawSamples);
      listen(id("statistic"), draw);
    }
    listen(id("measure"), draw);
    if (several && dimensions > 1) {
      id("less").append(...options(["nothing", ...group.names]));
      listen(id("less"), draw);
    }
    if (dimensions > 2) {
      [id("across"), id("up")].forEach((choice, which) => {
        choice.append(...options(group.axes.map((axis) => axis.name)));
        choice.value = plane[which];
        choice.addEventListener("change", () => {
          const chosen = Number(choice.value);
          plane = plane.includes(chosen) && plane[which] !== chosen ? [plane[1], plane[0]] : plane.with(which, chosen);
          [id("across").value, id("up").value] = plane;
          drawAxes();
          draw();
          point();
        });
      });
    }
    group.axes.forEach((axis, k) => {
      const choice = byId(`at-${place}-${k}`);
      choice.append(...options(axis.texts));
      choice.addEventListener("change", () => {
        cursor[k] = Number(choice.value);
        if (dimensions > 2 && !plane.includes(k)) draw();
        point();
      });
    });
    for (const box of document.querySelectorAll(`input[data-group="${place}"]`)) {
      box.addEventListener("change", () => {
        if (box.checked) dropped.delete(Number(box.dataset.sweep));
        else dropped.add(Number(box.dataset.sweep));
        draw();
      });
    }
    // a click on a cell, or on a strip of the lines
    const picked = (source, take) => source.selected.properties.indices.change.connect(() => {
      const [index] = source.selected.indices;
      if (index === undefined) return;
      take(index);
      point();
    });
    if (dimensions > 1) {
      for (const sweep of sweeps) {
        picked(model(`cells-${place}-${sweep}`), (index) => {
          const width = places[plane[0]].length;
          cursor[plane[0]] = index % width;
          cursor[plane[1]] = Math.floor(index / width);
        });
      }
      drawAxes();
    }
    if (dimensions === 1) picked(model(`strips-${place}`), (index) => { cursor[0] = index; });
    draw();
    point();
    id("controls").hidden = false;

    painters.push((darkly) => {
      const colours = darkly ? data.colours.dark : data.colours.light;
      for (const sweep of sweeps) {
        const colour = { value: colours[sweep % colours.length] };
        if (dimensions > 1) {
          paintAxes(model(`map-${place}-${sweep}`), darkly);
          model(`bar-${place}-${sweep}`).setv({
            major_label_text_color: ink(darkly), major_tick_line_color: ink(darkly),
          });
        }
        if (dimensions === 1) {
          panels.forEach((_, k) => {
            model(`stroke-${place}-${k}-${sweep}`).glyph.line_color = colour;
            model(`dot-${place}-${k}-${sweep}`).glyph.fill_color = colour;
            model(`ring-${place}-${k}-${sweep}`).glyph.line_color = colour;
            if (sampled) model(`band-${place}-${k}-${sweep}`).glyph.fill_color = colour;
          });
        }
        traces.forEach((_, panel) => {
          model(`trace-${place}-${panel}-${sweep}`).glyph.line_color = colour;
          if (sampled) for (const name of ["q0", "q1"]) model(`${name}-${place}-${panel}-${sweep}`).glyph.fill_color = colour;
        });
        if (sampled) {
          model(`stair-${place}-${sweep}`).glyph.line_color = colour;
          model(`spot-${place}-${sweep}`).glyph.fill_color = colour;
        }
      }
      if (dimensions === 1) panels.forEach((_, k) => paintAxes(model(`line-${place}-${k}`), darkly));
      traces.forEach((_, panel) => paintAxes(model(`series-${place}-${panel}`), darkly));
      if (sampled) for (const name of ["ecdf", "scatter"]) paintAxes(model(`${name}-${place}`), darkly);
    });
  });

  painted((darkly) => painters.forEach((paint) => paint(darkly)));
  byId("status").textContent = "";
  page.ready();
})();
