// Several runs over each other: how far apart their markers are, as series of their own.

/** Adds to the second and later runs, for each marker that the first has too, its distance from there. */
function addDistances(runs) {
  const [first, ...others] = runs;
  for (const run of others) {
    const shared = run.look.markers.filter((marker) => first.look.markers.some((each) => each.name === marker.name));
    if (!shared.length) continue;
    const values = shared.map((marker) => {
      const twin = first.look.markers.find((each) => each.name === marker.name);
      return Float64Array.from({ length: run.frames }, (_, row) => {
        const at = first.rowAt(run.time(row));
        return distance(markerAt(run, marker, { row, part: 0 }), markerAt(first, twin, at));
      });
    });
    const owners = shared.map((marker) => `${marker.name}, ${run.label}:`);
    run.groups.push({ name: "distance", kind: "pairs", owners, components: [""], units: owners.map(() => "m"), logarithmic: false });
    run.series.push({ rows: run.frames, at: (row, column) => values[column][row] });
  }
}
