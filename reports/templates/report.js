/* Makes the report handier: filters, sorting, addresses that keep them, and copying. All of it is readable without. */
(() => {
  "use strict";
  const explore = document.getElementById("explore");
  const form = document.getElementById("filters");
  const table = document.getElementById("cells");
  const list = document.querySelector(".findings");
  const rows = [...table.tBodies[0].rows].map((element, place) => ({
    element,
    place,
    pair: element.cells[0].textContent,
    query: element.cells[1].textContent,
    differ: "differ" in element.dataset,
    cells: [...element.querySelectorAll("td.first")],
  }));
  const findings = [...(list ? list.children : [])].map((element, place) => ({
    element,
    place,
    cell: element.dataset.c,
    isNew: "new" in element.dataset,
    words: element.querySelector("summary").textContent.toLowerCase(),
  }));
  let sort = "";

  // -- what is shown --------------------------------------------------------------------------------------

  function wanted() {
    const { engine, type, query, show, find, order } = form.elements;
    const index = engine.selectedOptions[0].dataset.index;
    return { index, type: type.value, query: query.value, show: show.value, find: find.value.trim().toLowerCase(), order: order ? order.value : "" };
  }

  function cellsShown(row, want) {
    const fits = (!want.type || row.pair.split("–").includes(want.type)) && (!want.query || row.query === want.query);
    if (!fits || (want.show === "differ" && !row.differ)) return [];
    return row.cells.filter((cell, engine) => {
      const flags = (cell.dataset.f || "").split(" ");
      return (want.index === undefined || engine === +want.index)
        && (!want.show || want.show === "differ" || flags.includes(want.show));
    });
  }

  function apply() {
    const want = wanted();
    const asked = [...new FormData(form).values()].some(Boolean);
    const shown = new Set();
    let count = 0;
    for (const row of rows) {
      const cells = cellsShown(row, want);
      row.element.hidden = !cells.length;
      count += cells.length;
      for (const cell of cells) shown.add(cell.id);
    }
    let found = 0;
    for (const finding of findings) {
      const fits = (finding.cell ? shown.has(finding.cell) : !asked) && (want.show !== "new" || finding.isNew)
        && (!want.find || finding.words.includes(want.find));
      finding.element.hidden = !fits;
      found += fits;
    }
    table.className = want.index === undefined ? "" : `only-${want.index}`;
    [...document.querySelector(".glances").children].forEach((glance, engine) => {
      glance.hidden = want.index !== undefined && engine !== +want.index;
    });
    explore.classList.toggle("filtered", asked);
    document.getElementById("shown").textContent =
      `${count} cell${count === 1 ? "" : "s"}, ${found} finding${found === 1 ? "" : "s"}`;
    arrange(findings, (finding) => want.order ? -(finding.element.dataset[want.order] || 0) : 0, 1);
  }

  // -- order ----------------------------------------------------------------------------------------------

  /* Put elements in the order of their keys; what has none comes last, equal ones stay as they were written. */
  function arrange(items, keyOf, sign) {
    if (!items.length) return;
    const keyed = items.map((item) => ({ item, key: keyOf(item) }));
    const compare = (a, b) => typeof a === "string" ? a.localeCompare(b) : a - b;
    keyed.sort((a, b) => (a.key === undefined) - (b.key === undefined)
      || (a.key === undefined ? 0 : sign * compare(a.key, b.key)) || a.item.place - b.item.place);
    const parent = items[0].element.parentNode;
    const inOrder = keyed.every(({ item }, place) => parent.children[place] === item.element);
    if (!inOrder) parent.append(...keyed.map(({ item }) => item.element));
  }

  function keyOfColumn(name) {
    const [what, engine] = name.split("-");
    if (what === "query") return (row) => row.query;
    if (what === "pair" || !name) return (row) => row.place;
    return (row) => {
      const value = row.cells[engine].dataset[what];
      return value === undefined ? undefined : +value;
    };
  }

  function sortRows() {
    const heads = [...table.querySelectorAll("th[data-sort]")];
    if (!heads.some((head) => head.dataset.sort === sort.replace(/^-/, ""))) sort = "";
    const down = sort.startsWith("-");
    const name = sort.replace(/^-/, "");
    for (const head of heads) {
      head.setAttribute("aria-sort", head.dataset.sort === name ? (down ? "descending" : "ascending") : "none");
    }
    arrange(rows, keyOfColumn(name), down ? -1 : 1);
  }

  function sortable(head) {
    const button = document.createElement("button");
    button.type = "button";
    button.append(...head.childNodes);
    head.append(button);
    // amounts are asked for from the largest on
    const first = /^(compared|worst)/.test(head.dataset.sort) ? "-" : "";
    button.addEventListener("click", () => {
      const here = first + head.dataset.sort;
      const turned = first ? head.dataset.sort : `-${head.dataset.sort}`;
      sort = sort === here ? turned : sort === turned ? "" : here;
      sortRows();
      keep();
    });
  }

  // -- the address ----------------------------------------------------------------------------------------

  function keep() {
    const query = new URLSearchParams();
    for (const [name, value] of new FormData(form)) if (value) query.set(name, value);
    if (sort) query.set("sort", sort);
    const search = query.toString();
    history.replaceState(null, "", `${location.pathname}${search && "?"}${search}${location.hash}`);
  }

  function restore(search) {
    const query = new URLSearchParams(search);
    for (const element of form.elements) {
      if (!element.name) continue;
      element.value = query.get(element.name) || "";
      if (element.selectedIndex === -1) element.selectedIndex = 0;
    }
    sort = query.get("sort") || "";
    sortRows();
    apply();
  }

  /* Open the finding that the address names, and bring it into sight, even if the filter hides it. */
  function reveal() {
    const target = document.getElementById(location.hash.slice(1));
    if (!target) return;
    if (target.closest("[hidden]")) {
      restore("");
      keep();
    }
    for (let box = target.closest("details"); box; box = box.parentElement.closest("details")) box.open = true;
    target.scrollIntoView({ block: target.matches("article, section") ? "start" : "center" });
  }

  // -- rows that open to more of them ------------------------------------------------------------------------

  /* An error as it is sent, 12-9 for 1.2e-09, and that the worst of a regime is certain by floats alone. */
  function decoded(code, place) {
    if (!code || code === "0") return code || "–";
    const text = code.replace(/^(\d)(\d)([+-])(\d+)$/, (_, a, b, sign, power) => `${a}.${b}e${sign}${power.padStart(2, "0")}`);
    return place % 3 === 2 ? `≥ ${text}` : text;
  }

  /* The rows below one: a heading, and for each group of columns its errors and, behind them, what stands below these. */
  function below(row, more) {
    return more.map(([heading, ...groups]) => {
      const line = document.createElement("tr");
      line.className = "more";
      const head = line.appendChild(document.createElement("th"));
      head.scope = "row";
      head.textContent = heading;
      if (!groups.length) head.colSpan = row.cells.length;
      const width = groups.length && (row.cells.length - 1) / groups.length;
      for (const group of groups) {
        const codes = group === "0" ? Array(2 * width).fill("0") : group.split("|");
        for (let k = 0; k < width; k += 1) {
          const cell = line.appendChild(document.createElement("td"));
          cell.textContent = decoded(codes[k], k);
          if (group) cell.appendChild(document.createElement("small")).textContent = decoded(codes[width + k], k);
        }
      }
      return line;
    });
  }

  function opening(row, more) {
    const head = row.cells[0];
    const button = document.createElement("button");
    let opened = [];
    button.type = "button";
    button.append(...head.childNodes);
    button.setAttribute("aria-expanded", "false");
    button.title = "Its regimes";
    head.append(button);
    button.addEventListener("click", () => {
      for (const line of opened) line.remove();
      opened = opened.length ? [] : below(row, more);
      row.after(...opened);
      button.setAttribute("aria-expanded", String(opened.length > 0));
    });
  }

  // -- copying --------------------------------------------------------------------------------------------

  async function copy(text) {
    try {
      await navigator.clipboard.writeText(text);
    } catch {
      const area = document.createElement("textarea");
      area.value = text;
      document.body.append(area);
      area.select();
      document.execCommand("copy");
      area.remove();
    }
  }

  function copyButton(code) {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = "Copy";
    button.setAttribute("aria-label", "Copy the command");
    button.addEventListener("click", async () => {
      await copy(code.textContent);
      button.textContent = "Copied";
      setTimeout(() => { button.textContent = "Copy"; }, 1500);
    });
    code.after(" ", button);
  }

  // -- beginning ------------------------------------------------------------------------------------------

  for (const element of document.querySelectorAll("#filters, #order")) element.hidden = false;
  table.querySelectorAll("th[data-sort]").forEach(sortable);
  document.querySelectorAll(".command code").forEach(copyButton);
  for (const data of document.querySelectorAll("script.more")) {
    const lines = [...data.previousElementSibling.tBodies[0].rows];
    JSON.parse(data.textContent).forEach((more, place) => { if (more.length) opening(lines[place], more); });
  }
  form.addEventListener("input", () => { apply(); keep(); });
  form.addEventListener("submit", (event) => event.preventDefault());
  form.addEventListener("reset", (event) => { event.preventDefault(); restore(""); keep(); });
  document.addEventListener("click", (event) => {
    const link = event.target.closest("a[href^='?']");
    if (!link) return;
    event.preventDefault();
    history.pushState(null, "", link.href);
    restore(location.search);
    reveal();
  });
  window.addEventListener("hashchange", reveal);
  window.addEventListener("popstate", () => restore(location.search));
  restore(location.search);
  reveal();
})();
