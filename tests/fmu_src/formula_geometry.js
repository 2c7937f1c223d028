// What is wrong with the formulas of a page, by the places of boxes and by the ink of glyphs, which a canvas measures.
() => {
  const brush = document.createElement("canvas").getContext("2d");
  const found = { fractions: 0, scripts: 0, brackets: 0, roots: 0, dots: 0, texts: 0, wrong: [] };
  const glyphs = new Map();
  const box = (element) => element.getBoundingClientRect();
  const size = (element) => parseFloat(getComputedStyle(element).fontSize);

  // A box without size stands on the baseline. All are put in at once, as each change lays out the page anew.
  const hanging = ".fx-fraction, .fx-sub, .fx-sup, .fx-stack, .fx-tall-sub, .fx-tall-sup, .fx-limited, .fx-bracketed, "
    + ".fx-root";
  const nodes = [...document.querySelectorAll(".fx-seen")]
    .flatMap((seen) => [...seen.querySelectorAll(hanging), ...textsIn(seen)]);
  const probes = nodes.map((node) => {
    const probe = document.createElement("span");
    probe.style.cssText = "display:inline-block;width:0;height:0";
    node.parentNode.insertBefore(probe, node);
    return probe;
  });
  const baselines = new Map(probes.map((probe, index) => [nodes[index], box(probe).bottom]));
  probes.forEach((probe) => probe.remove());

  function textsIn(element) {
    const walker = document.createTreeWalker(element, NodeFilter.SHOW_TEXT);
    const all = [];
    while (walker.nextNode()) if (walker.currentNode.data.trim()) all.push(walker.currentNode);
    return all;
  }

  function measured(text, element) {
    const style = getComputedStyle(element);
    const font = `${style.fontStyle} ${style.fontWeight} 1000px ${style.fontFamily}`; // large, as it counts whole pixels
    if (!glyphs.has(font + text)) {
      brush.font = font;
      glyphs.set(font + text, brush.measureText(text));
    }
    const { actualBoundingBoxAscent: ascent, actualBoundingBoxDescent: descent } = glyphs.get(font + text);
    const scale = parseFloat(style.fontSize) / 1000;
    return { ascent: ascent * scale, descent: descent * scale };
  }

  function ink(node) {
    const range = document.createRange();
    range.selectNodeContents(node);
    const { left, right } = range.getBoundingClientRect();
    const height = measured(node.data, node.parentElement);
    const line = baselines.get(node);
    return {
      text: node.data, em: size(node.parentElement), left, right, line,
      top: line - height.ascent, bottom: line + height.descent,
    };
  }

  const inks = (element) => textsIn(element).map(ink);

  const extent = (list) => ({
    left: Math.min(...list.map((one) => one.left)), right: Math.max(...list.map((one) => one.right)),
    top: Math.min(...list.map((one) => one.top)), bottom: Math.max(...list.map((one) => one.bottom)),
  });

  for (const formula of document.querySelectorAll(".formula")) {
    const copied = formula.querySelector(".fx-copied").textContent;
    const expect = (holds, what) => holds || found.wrong.push(`${copied}: ${what}`);
    const each = (selector, examine) => formula.querySelectorAll(selector).forEach(examine);

    each(".fx-fraction", (fraction) => {
      found.fractions += 1;
      const [above, below] = fraction.children;
      const em = size(fraction.parentElement);
      const minus = measured("\u2212", fraction.parentElement);
      const axis = baselines.get(fraction) - (minus.ascent - minus.descent) / 2;
      const bar = box(below).top + parseFloat(getComputedStyle(below).borderTopWidth) / 2;
      expect(Math.abs(bar - axis) < 0.06 * em, `a bar is ${((axis - bar) / em).toFixed(3)} em above the axis`);
      const [over, under] = [above, below].map((part) => extent(inks(part)));
      expect(over.bottom + 0.06 * em < bar && bar < under.top - 0.06 * em, "a bar touches what it divides");
      expect(box(below).left <= Math.min(over.left, under.left), "a bar is too short at the left");
      expect(box(below).right >= Math.max(over.right, under.right), "a bar is too short at the right");
    });

    each(".fx-sub, .fx-sup, .fx-stack > *, .fx-limits > *, .fx-far-sup, .fx-far-sub", (script) => {
      found.scripts += 1;
      const parent = script.parentElement;
      const limits = parent.matches(".fx-limits");
      const stacked = limits || parent.matches(".fx-stack");
      const tall = limits || parent.matches(".fx-tall-sub, .fx-tall-sup");
      const whole = limits ? parent.parentElement : stacked || tall ? parent : script;
      const base = (stacked ? parent : script).previousSibling;
      const text = base.nodeType === Node.TEXT_NODE ? ink(base) : box(base);
      const inside = inks(script);
      const raised = script.matches(".fx-sup, .fx-upper, .fx-far-sup");
      const em = size(whole.parentElement);
      const shift = (baselines.get(whole) - inside[0].line) / em;
      expect(raised ? shift > 0.25 : shift < -0.1, `a script is ${shift.toFixed(2)} em above the baseline`);
      if (script.matches(".fx-far-sup")) expect(extent(inside).top < box(base).top, "a script does not stand out");
      const high = tall || script.querySelector(".fx-fraction");
      expect(Math.abs(shift) < (high ? 2.5 : 0.6), "a script is far from its base");
      expect(size(script) < 0.85 * em, "a script is as large as its base");
      expect(inside[0].left > text.right - (limits ? 0.6 : 0.02) * em, "a script is not right of its base");
    });

    each(".fx-bracketed, .fx-root", (around) => {
      const content = around.querySelector(".fx-content");
      const within = [...textsIn(content), ...content.querySelectorAll(hanging)];
      const own = within.find((node) => node.parentElement.closest(hanging) === around);
      expect(Math.abs(baselines.get(own) - baselines.get(around)) < 0.02 * size(around), "a content has left the line");
    });

    each(".fx-bracketed", (bracketed) => {
      const [left, content, right] = bracketed.children;
      const inside = extent(inks(content));
      for (const bracket of [left, right].map(box)) {
        found.brackets += 1;
        expect(bracket.top <= inside.top && bracket.bottom >= inside.bottom, "a bracket is lower than its content");
        expect(bracket.height < 1.6 * (inside.bottom - inside.top), "a bracket is far higher than its content");
      }
      expect(box(left).right <= inside.left + 0.05 * size(content), "a bracket runs into its content");
      expect(box(right).left >= inside.right - 0.05 * size(content), "a bracket runs into its content");
    });

    each(".fx-root", (root) => {
      found.roots += 1;
      const [sign, content] = root.children;
      const inside = extent(inks(content));
      const roof = box(content).top + parseFloat(getComputedStyle(content).borderTopWidth);
      expect(roof < inside.top && box(sign).bottom >= inside.bottom, "a root is lower than its content");
      const covered = box(content).left <= inside.left && box(content).right >= inside.right;
      expect(covered, "a root does not cover its content");
      expect(Math.abs(box(sign).right - box(content).left) < 0.5, "the bar of a root begins elsewhere than its sign");
    });

    each(".fx-dotted", (dotted) => {
      found.dots += 1;
      const letter = inks(dotted)[0];
      const dot = box(dotted.querySelector(".fx-dot"));
      expect(dot.bottom < letter.top && dot.top > letter.top - 0.4 * letter.em, "a dot is not on its letter");
      expect(dot.left > letter.left && dot.right < letter.right + 0.1 * letter.em, "a dot is beside its letter");
    });

    const texts = inks(formula.querySelector(".fx-seen"));
    found.texts += texts.length;
    texts.forEach((one, index) => {
      for (const other of texts.slice(index + 1)) {
        const wide = Math.min(one.right, other.right) - Math.max(one.left, other.left);
        const high = Math.min(one.bottom, other.bottom) - Math.max(one.top, other.top);
        expect(wide < 0.03 * one.em || high < 0, `${one.text} and ${other.text} overlap`);
      }
    });

    const spoken = box(formula.querySelector(".fx-spoken"));
    expect(spoken.width <= 1 && spoken.height <= 1, "the MathML can be seen");
    expect(getComputedStyle(formula.querySelector(".fx-copied")).color.endsWith(", 0)"), "the text to copy can be seen");
  }

  for (const equation of document.querySelectorAll(".formula-equation")) {
    const [room, label] = [...equation.children].map(box);
    const held = box(equation);
    if (room.left < held.left || room.right > held.right + 0.5) found.wrong.push("a formula leaves its column");
    if (!label) continue;
    if (Math.abs(label.right - held.right) > 0.5) found.wrong.push("a label is not at the right");
    const beside = label.left >= room.right && Math.abs(label.top + label.bottom - room.top - room.bottom) < 2;
    if (!beside && label.top < room.bottom) found.wrong.push("a label is neither beside its formula nor below it");
  }
  return found;
}
