"use strict";
(async () => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  const byId = (id) => document.getElementById(id);
  const plots = data.shown.map((_, plot) => plot);
  const visible = data.runs.map(() => true);
  const shown = [...data.shown];

  // 65,535 parts of the range; the last stands for no number
  const numbers = ([least, part, text]) => {
    const bytes = Uint8Array.from(atob(text), (each) => each.charCodeAt(0));
    const parts = new DataView(bytes.buffer);
    const found = new Float64Array(bytes.length / 2);
    for (let k = 0; k < found.length; k += 1) {
      const count = parts.getUint16(2 * k, true);
      found[k] = count === 65535 ? NaN : least + count * part;
    }
    return found;
  };

  const roots = {};
  data.document.roots.forEach((root, plot) => { roots[root.id] = `panel-${plot}`; });
  const item = { docid: "report", roots, root_ids: Object.keys(roots) };
  for (const plot of plots) byId(`panel-${plot}`).dataset.rootId = data.document.roots[plot].id;
  await Bokeh.embed.embed_items({ report: data.document }, [item]);
  const model = (name) => Bokeh.documents[0].get_model_by_name(name);
  const time = model("time");

  const heading = (signal) => (signal.unit ? `${signal.name} [${signal.unit}]` : signal.name);

  // Bokeh would take these for the marks of mathematics, and ask for a script that draws it
  const unmarked = (text) => text.replace(/\$\$/g, "$\u200b$").replace(/\\([[(])/g, "\\\u200b$1");

  const fill = (plot) => {
    const signal = data.signals[shown[plot]];
    model(`panel-${plot}`).left[0].axis_label = unmarked(heading(signal));
    data.runs.forEach((_, run) => {
      const line = signal.lines[run];
      model(`source-${plot}-${run}`).data = line ? { x: numbers(line.x), y: numbers(line.y) } : { x: [], y: [] };
    });
    const names = data.runs.filter((_, run) => visible[run] && signal.lines[run]);
    byId(`caption-${plot}`).textContent = `${heading(signal)} over time, of ${names.join(", ") || "no run"}`;
  };

  const tabulate = (plot) => {
    const signal = data.signals[shown[plot]];
    byId(`numbers-${plot}`).textContent = `${heading(signal)}, over the whole run`;
    byId(`rows-${plot}`).replaceChildren(...data.runs.map((run, place) => {
      const row = document.createElement("tr");
      const head = document.createElement("th");
      head.scope = "row";
      head.textContent = run;
      row.append(head);
      for (const text of signal.table[place]) {
        const cell = document.createElement("td");
        cell.className = "number";
        cell.textContent = text;
        row.append(cell);
      }
      return row;
    }));
  };

  // by component, the part of a name before its first dot
  const options = () => {
    const groups = new Map();
    data.signals.forEach((signal, place) => {
      const component = signal.name.split(".")[0];
      if (!groups.has(component)) {
        const group = document.createElement("optgroup");
        group.label = component;
        groups.set(component, group);
      }
      const option = document.createElement("option");
      option.value = place;
      option.textContent = heading(signal);
      groups.get(component).append(option);
    });
    return [...groups.values()];
  };

  const paint = (darkly) => {
    const ink = darkly ? "#e6eaee" : "#1a1f26";
    const rule = darkly ? "#3b4550" : "#d5dbe1";
    const colours = darkly ? data.colours.dark : data.colours.light;
    for (const plot of plots) {
      const panel = model(`panel-${plot}`);
      for (const axis of [...panel.below, ...panel.left]) {
        axis.setv({
          axis_label_text_color: ink, major_label_text_color: ink, axis_line_color: ink, major_tick_line_color: ink,
          minor_tick_line_color: ink, axis_label_text_font_style: "normal",
        });
      }
      for (const grid of panel.center) grid.setv({ grid_line_color: rule });
      data.runs.forEach((_, run) => {
        model(`line-${plot}-${run}`).glyph.line_color = { value: colours[run % colours.length] };
      });
    }
  };

  const follow = () => {
    byId("begin").value = Number(time.start.toPrecision(7));
    byId("end").value = Number(time.end.toPrecision(7));
  };

  const zoom = (start, end) => {
    const begin = Math.max(data.begin, start);
    const until = Math.min(data.end, end);
    if (!(begin < until)) {
      byId("status").textContent = `Expected times between ${data.begin} s and ${data.end} s, the earlier one first.`;
      return;
    }
    time.setv({ start: begin, end: until });
    byId("status").textContent = `Plots show ${begin} s to ${until} s.`;
  };

  for (const plot of plots) {
    const choice = document.querySelector(`select[data-plot="${plot}"]`);
    choice.append(...options());
    choice.value = shown[plot];
    choice.addEventListener("change", () => {
      shown[plot] = Number(choice.value);
      fill(plot);
      tabulate(plot);
    });
    choice.parentElement.hidden = false;
    fill(plot);
  }
  for (const box of document.querySelectorAll("input[data-run]")) {
    box.addEventListener("change", () => {
      const run = Number(box.dataset.run);
      visible[run] = box.checked;
      for (const plot of plots) {
        model(`line-${plot}-${run}`).visible = box.checked;
        fill(plot);
      }
    });
  }
  byId("controls").addEventListener("submit", (event) => {
    event.preventDefault();
    zoom(byId("begin").valueAsNumber, byId("end").valueAsNumber);
  });
  byId("whole").addEventListener("click", () => zoom(data.begin, data.end));
  time.change.connect(() => requestAnimationFrame(follow));
  follow();
  paint(dark.matches);
  dark.addEventListener("change", () => paint(dark.matches));
  window.addEventListener("beforeprint", () => paint(false));
  window.addEventListener("afterprint", () => paint(dark.matches));
  byId("controls").hidden = false;
  document.documentElement.dataset.ready = "yes";
})();
