// Merges two edits of one text, line by line.

export type Piece =
    | { kind: 'same' | 'mine' | 'theirs'; lines: string[] }
    | { kind: 'conflict'; mine: string[]; theirs: string[] };

/** For each line of `a` its partner in `b`, or -1: a longest common subsequence. */
export function partners(a: string[], b: string[]): number[] {
    const width = b.length + 1;
    const longest = new Uint32Array((a.length + 1) * width);
    for (let i = a.length - 1; i >= 0; i -= 1) {
        for (let j = b.length - 1; j >= 0; j -= 1) {
            longest[i * width + j] = a[i] === b[j]
                ? longest[(i + 1) * width + j + 1]! + 1
                : Math.max(longest[(i + 1) * width + j]!, longest[i * width + j + 1]!);
        }
    }
    const found = new Array<number>(a.length).fill(-1);
    for (let i = 0, j = 0; i < a.length && j < b.length;) {
        if (a[i] === b[j]) {
            found[i] = j;
            i += 1;
            j += 1;
        } else if (longest[(i + 1) * width + j]! >= longest[i * width + j + 1]!) {
            i += 1;
        } else {
            j += 1;
        }
    }
    return found;
}

const equal = (a: string[], b: string[]): boolean =>
    a.length === b.length && a.every((line, i) => line === b[i]);

function judge(base: string[], mine: string[], theirs: string[]): Piece[] {
    if (base.length + mine.length + theirs.length === 0) {
        return [];
    }
    if (equal(mine, theirs)) {
        return [{ kind: 'same', lines: mine }];
    }
    if (equal(base, mine)) {
        return [{ kind: 'theirs', lines: theirs }];
    }
    return equal(base, theirs) ? [{ kind: 'mine', lines: mine }]
        : [{ kind: 'conflict', mine, theirs }];
}

/** Pieces in their order; only a conflict needs a person. */
export function merge(baseText: string, mineText: string, theirsText: string): Piece[] {
    const base = baseText.split('\n');
    const mine = mineText.split('\n');
    const theirs = theirsText.split('\n');
    const inMine = partners(base, mine);
    const inTheirs = partners(base, theirs);
    const pieces: Piece[] = [];
    let [b, m, t] = [0, 0, 0];
    for (let i = 0; i <= base.length; i += 1) {
        const end = i === base.length;
        const toMine = end ? mine.length : inMine[i]!;
        const toTheirs = end ? theirs.length : inTheirs[i]!;
        if (toMine < 0 || toTheirs < 0) {
            continue;
        }
        pieces.push(...judge(base.slice(b, i), mine.slice(m, toMine), theirs.slice(t, toTheirs)));
        if (!end) {
            pieces.push({ kind: 'same', lines: [base[i]!] });
        }
        [b, m, t] = [i + 1, toMine + 1, toTheirs + 1];
    }
    return joinSame(pieces);
}

function joinSame(pieces: Piece[]): Piece[] {
    const joined: Piece[] = [];
    for (const piece of pieces) {
        const last = joined.at(-1);
        if (piece.kind === 'same' && last?.kind === 'same') {
            last.lines = [...last.lines, ...piece.lines];
        } else {
            joined.push(piece);
        }
    }
    return joined;
}
