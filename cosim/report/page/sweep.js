"use strict";
(async () => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  const byId = (id) => document.getElementById(id);

  // 65,535 parts of the range; the last stands for no number
  const numbers = ([least, part, text]) => {
    const bytes = Uint8Array.from(atob(text), (each) => each.charCodeAt(0));
    const parts = new DataView(bytes.buffer);
    return Array.from({ length: bytes.length / 2 }, (_, k) => {
      const count = parts.getUint16(2 * k, true);
      return count === 65535 ? NaN : least + count * part;
    });
  };
  // Bokeh would take these for the marks of mathematics, and ask for a script that draws it
  const unmarked = (text) => text.replace(/\$\$/g, "$\u200b$").replace(/\\([[(])/g, "\\\u200b$1");
  const heading = (each) => (each.unit ? `${each.name} [${each.unit}]` : each.name);
  const short = (value) => (Number.isNaN(value) ? "-" : String(Number(value.toPrecision(6))));

  const edges = (values) => {
    const middles = values.slice(1).map((each, k) => (each + values[k]) / 2);
    const width = values.length > 1 ? values[1] - values[0] : 1;
    const last = values.length > 1 ? values.at(-1) - values.at(-2) : 1;
    return [values[0] - width / 2, ...middles, values.at(-1) + last / 2];
  };

  const roots = {};
  data.document.roots.forEach((root, place) => { roots[root.id] = `map-${place}`; });
  const item = { docid: "report", roots, root_ids: Object.keys(roots) };
  data.document.roots.forEach((root, place) => { byId(`map-${place}`).dataset.rootId = root.id; });
  await Bokeh.embed.embed_items({ report: data.document }, [item]);
  const model = (name) => Bokeh.documents[0].get_model_by_name(name);

  data.maps.forEach((map, place) => {
    const [x, y] = map.axes;
    const [ex, ey] = [edges(x.values), edges(y.values)];
    const figure = model(`map-${place}`);
    const values = map.measures.map((each) => numbers(each.values));
    // row by row upwards, as values are
    const cells = { left: [], right: [], bottom: [], top: [] };
    y.values.forEach((_, j) => x.values.forEach((__, i) => {
      cells.left.push(ex[i]);
      cells.right.push(ex[i + 1]);
      cells.bottom.push(ey[j]);
      cells.top.push(ey[j + 1]);
    }));
    figure.below[0].axis_label = unmarked(heading(x));
    figure.left[0].axis_label = unmarked(heading(y));

    const show = () => {
      const shown = Number(byId(`measure-${place}`).value);
      const known = values[shown].filter(Number.isFinite);
      const [low, high] = known.length ? [Math.min(...known), Math.max(...known)] : [0, 1];
      model(`colours-${place}`).setv({ low, high: high > low ? high : low + 1 });
      model(`cells-${place}`).data = { ...cells, value: values[shown] };
      model(`bar-${place}`).title = unmarked(heading(map.measures[shown]));
    };

    const point = () => {
      const [i, j] = [Number(byId(`x-${place}`).value), Number(byId(`y-${place}`).value)];
      model(`cursor-${place}`).data = { left: [ex[i]], right: [ex[i + 1]], bottom: [ey[j]], top: [ey[j + 1]] };
      const where = `${x.name} ${short(x.values[i])} ${x.unit}, ${y.name} ${short(y.values[j])} ${y.unit}`;
      byId(`point-${place}`).textContent = `Point at the cursor: ${where}`;
      byId(`values-${place}`).replaceChildren(...map.measures.map((each, k) => {
        const row = document.createElement("tr");
        const head = document.createElement("th");
        head.scope = "row";
        head.textContent = heading(each);
        const cell = document.createElement("td");
        cell.className = "number";
        cell.textContent = short(values[k][j * x.values.length + i]);
        row.append(head, cell);
        return row;
      }));
      byId("status").textContent = `Cursor at ${where}.`;
    };

    const fill = (id, texts) => byId(id).append(...texts.map((text, k) => {
      const option = document.createElement("option");
      option.value = k;
      option.textContent = text;
      return option;
    }));
    fill(`measure-${place}`, map.measures.map((each) => (each.label ? `${heading(each)}: ${each.label}` : heading(each))));
    fill(`x-${place}`, x.values.map(short));
    fill(`y-${place}`, y.values.map(short));
    byId(`x-name-${place}`).textContent = heading(x);
    byId(`y-name-${place}`).textContent = heading(y);
    const preferred = map.measures.findIndex((each) => each.name === "ssi");
    byId(`measure-${place}`).value = Math.max(0, preferred);
    byId(`measure-${place}`).addEventListener("change", show);
    for (const id of [`x-${place}`, `y-${place}`]) byId(id).addEventListener("change", point);
    const selected = model(`cells-${place}`).selected;
    selected.properties.indices.change.connect(() => {
      const [index] = selected.indices;
      if (index === undefined) return;
      byId(`x-${place}`).value = index % x.values.length;
      byId(`y-${place}`).value = Math.floor(index / x.values.length);
      point();
    });
    show();
    point();
    byId(`controls-${place}`).hidden = false;
  });

  const paint = (darkly) => {
    const ink = darkly ? "#e6eaee" : "#1a1f26";
    data.maps.forEach((_, place) => {
      const figure = model(`map-${place}`);
      for (const axis of [...figure.below, ...figure.left]) {
        axis.setv({
          axis_label_text_color: ink, major_label_text_color: ink, axis_line_color: ink, major_tick_line_color: ink,
          minor_tick_line_color: ink, axis_label_text_font_style: "normal",
        });
      }
      model(`bar-${place}`).setv({ title_text_color: ink, major_label_text_color: ink, title_text_font_style: "normal" });
    });
  };
  paint(dark.matches);
  dark.addEventListener("change", () => paint(dark.matches));
  window.addEventListener("beforeprint", () => paint(false));
  window.addEventListener("afterprint", () => paint(dark.matches));
  document.documentElement.dataset.ready = "yes";
})();
