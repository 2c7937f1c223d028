(async () => {
  const { byId, numbers, heading, unmarked, row, embed, paintAxes, painted } = page;
  const data = JSON.parse(byId("data").textContent);
  const plots = data.shown.map((_, plot) => plot);
  const visible = data.runs.map(() => true);
  const shown = [...data.shown];
  const model = await embed(data.document);
  const time = model("time");

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
    byId(`rows-${plot}`).replaceChildren(...data.runs.map((run, place) => row(run, signal.table[place])));
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
    const colours = darkly ? data.colours.dark : data.colours.light;
    for (const plot of plots) {
      paintAxes(model(`panel-${plot}`), darkly);
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
  painted(paint);
  byId("controls").hidden = false;
  page.ready();
})();
