// Completes keys, tables and values from the JSON schema of configurations.
import type { Completion, CompletionContext, CompletionResult } from '@codemirror/autocomplete';

export interface Schema {
    description?: string;
    type?: string;
    enum?: (string | number)[];
    default?: unknown;
    properties?: Record<string, Schema>;
    patternProperties?: Record<string, Schema>;
    items?: Schema;
    anyOf?: Schema[];
    oneOf?: Schema[];
}

const alternatives = (schema: Schema): Schema[] =>
    [schema, ...[...(schema.anyOf ?? []), ...(schema.oneOf ?? [])].flatMap(alternatives)];

function child(schemas: Schema[], name: string): Schema[] {
    return schemas.flatMap(alternatives).flatMap((one) => {
        const exact = one.properties?.[name];
        const found = exact ? [exact] : Object.entries(one.patternProperties ?? {})
            .filter(([pattern]) => new RegExp(pattern).test(name)).map(([, schema]) => schema);
        return found.flatMap((schema) => schema.items ? [schema.items] : [schema]);
    });
}

export function schemaAt(schema: Schema, path: string[]): Schema[] {
    return path.reduce<Schema[]>(child, [schema]);
}

const HEADER = /^\s*\[+\s*([^\]]*?)\s*\]+/;

export function pathOf(header: string): string[] {
    return header.split('.').map((part) => part.trim().replaceAll('"', '')).filter(Boolean);
}

/** The table that the end of `lines` stands in, and the keys that it has already. */
function tableOf(lines: string[]): { path: string[]; keys: Set<string> } {
    const keys = new Set<string>();
    for (const line of lines.toReversed()) {
        const header = HEADER.exec(line);
        if (header) {
            return { path: pathOf(header[1] ?? ''), keys };
        }
        const key = /^\s*([\w-]+)\s*=/.exec(line)?.[1];
        if (key) {
            keys.add(key);
        }
    }
    return { path: [], keys };
}

function keysOf(schemas: Schema[], taken: Set<string>): Completion[] {
    const found = new Map<string, Completion>();
    for (const [label, schema] of schemas.flatMap(alternatives)
        .flatMap((one) => Object.entries(one.properties ?? {}))) {
        if (!taken.has(label) && !found.has(label)) {
            const table = schema.type === 'object' && schema.patternProperties !== undefined;
            found.set(label, { label, type: 'property', info: schema.description,
                detail: schema.default === undefined ? '' : JSON.stringify(schema.default),
                apply: table ? label : `${label} = ` });
        }
    }
    return [...found.values()];
}

function valuesOf(schemas: Schema[]): Completion[] {
    const values = new Set<string>();
    for (const one of schemas.flatMap(alternatives)) {
        one.enum?.forEach((value) => values.add(JSON.stringify(value)));
        if (one.type === 'boolean') {
            values.add('true').add('false');
        }
        if (typeof one.default === 'string' || typeof one.default === 'number') {
            values.add(JSON.stringify(one.default));
        }
    }
    return [...values].map((label) => ({ label, type: 'constant' }));
}

/** "input.NAME" for tables of tables, "runtime" for the others. */
function tablesOf(schema: Schema, path: string[]): Completion[] {
    const before = path.length === 0 ? '' : `${path.join('.')}.`;
    return keysOf(schemaAt(schema, path), new Set()).map(({ label, info }) => ({
        label: before + label, type: 'namespace', info,
    }));
}

export function complete(schema: Schema, context: CompletionContext): CompletionResult | null {
    const line = context.state.doc.lineAt(context.pos);
    const before = line.text.slice(0, context.pos - line.from);
    const header = /^\s*\[+\s*([\w."-]*)$/.exec(before);
    if (header) {
        const path = pathOf((header[1] ?? '').replace(/[^.]*$/, ''));
        return { from: context.pos - (header[1] ?? '').length, options: tablesOf(schema, path) };
    }
    const lines = context.state.doc.sliceString(0, line.from).split('\n');
    const { path, keys } = tableOf(lines);
    const value = /^\s*([\w-]+)\s*=\s*("?[\w-]*)$/.exec(before);
    if (value) {
        const options = valuesOf(schemaAt(schema, [...path, value[1] ?? '']));
        return { from: context.pos - (value[2] ?? '').length, options };
    }
    const key = /^\s*([\w-]*)$/.exec(before);
    if (key && (key[1] !== '' || context.explicit)) {
        return { from: context.pos - (key[1] ?? '').length,
            options: keysOf(schemaAt(schema, path), keys) };
    }
    return null;
}
