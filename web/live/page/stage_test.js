// The test of the visitor's GPU: every stage beside its twin, by one visibility after the other.

class StageTest {
  constructor(page) {
    this.page = page;
    this.element = page.element.querySelector(".hardware");
    this.report = null;
    this.button("test").addEventListener("click", () => this.run());
    this.button("copy").addEventListener("click", () => navigator.clipboard.writeText(JSON.stringify(this.report, null, 2)));
  }

  button(name) {
    return this.element.querySelector(`[data-do=${name}]`);
  }

  // Tests the texels of the latest solve.
  async run() {
    const { page } = this;
    const { solved } = page;
    const shaders = page.changed_shaders();
    const { texels, patches, pixels } = page.request();
    const names = [...page.form.elements.visibility.options].map(({ value }) => value);
    this.forget();
    this.report = { browser: navigator.userAgent, scene: page.scene.name, texels, patches, pixels, shaders, visibilities: [] };
    this.button("test").disabled = true;
    try {
      for (const visibility of names) {
        this.say("", `Test ${this.report.visibilities.length + 1} of ${names.length}: ${visibility} …`);
        const checked = await page.program.ask("test", { visibility, pixels, shaders });
        if (solved !== page.solved) return;
        this.report.visibilities.push({ visibility, ...checked });
        this.show();
      }
      this.conclude();
    } catch (error) {
      const reason = error instanceof Ended ? "the scene was solved anew" : error.message;
      this.say("disagree", `The test did not come to its end: ${reason}`);
    } finally {
      this.button("test").disabled = false;
    }
  }

  // Shows stage × visibility: right, wrong, or not run.
  show() {
    const { visibilities } = this.report;
    const stages = new Set(visibilities.flatMap(({ checks }) => checks.map(({ name }) => name)));
    const row = (tag, cells) => make("tr", {}, cells.map((cell) => (typeof cell === "string" ? make(tag, {}, [cell]) : cell)));
    const table = this.element.querySelector(".stages");
    table.replaceChildren(
      row("th", ["stage", ...visibilities.map(({ visibility }) => visibility)]),
      ...[...stages].map((stage) => row("td", [stage, ...visibilities.map(({ checks }) => stage_cell(checks.find(({ name }) => name === stage)))])),
    );
    table.hidden = false;
    const wrong = visibilities.flatMap(({ visibility, checks, refusal }) => [
      ...checks.filter(({ agree }) => !agree).map((check) => `${visibility}, ${check.name}: ${describe_difference(check)}`),
      ...(refusal ? [`${visibility}: ${refusal}`] : []),
    ]);
    this.element.querySelector(".differences").replaceChildren(...wrong.map((line) => make("li", {}, [line])));
    this.button("copy").disabled = false;
  }

  conclude() {
    const { visibilities, shaders } = this.report;
    const checks = visibilities.flatMap((checked) => checked.checks);
    const wrong = checks.filter(({ agree }) => !agree).length;
    const { adapter, driver, software } = visibilities[0];
    const changed = shaders.map(({ name }) => `, ${name}.wgsl changed`).join("");
    this.say(wrong === 0 && checks.length > 0 ? "agree" : "disagree",
      `${adapter} (${driver}${software ? ", on the CPU" : ""})${changed}: ${checks.length - wrong} checks are right, ${wrong} wrong.`);
  }

  say(tone, text) {
    const place = this.element.querySelector(".told");
    place.className = `told verdict ${tone}`;
    place.hidden = text === "";
    place.textContent = text;
  }

  // Removes a test that is of an earlier solve.
  forget() {
    this.report = null;
    this.say("", "");
    this.element.querySelector(".stages").hidden = true;
    this.element.querySelector(".differences").replaceChildren();
    this.button("copy").disabled = true;
  }
}

// Returns the cell of a check; of none, the stage was not run.
function stage_cell(check) {
  if (!check) return make("td", {}, ["not run"]);
  const { values, differing, worst, bound, reason, agree } = check;
  const title = `${values} values, ${differing} differ, by ${worst ?? "no number"} of at most ${bound}: ${reason}`;
  return make("td", { class: agree ? "agree" : "disagree", title }, [agree ? "right" : "wrong"]);
}

// Says where a stage differs from its twin at first.
function describe_difference({ difference, reason }) {
  if (!difference) return reason;
  const { first, beyond, values, pattern } = difference;
  return `${first.element}: ${first.gpu} on the GPU, ${first.twin} in the twin; ${beyond} of ${values} differ: ${pattern}`;
}
