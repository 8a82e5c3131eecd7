// Earlier configurations: load one into the editor.
import { useEffect, useState } from 'preact/hooks';
import { errorText, get, getText } from '../model/api';
import { api } from '../model/store';

interface Earlier {
    id: string;
    time: string;
    bytes: number;
}

export function HistoryView({ use }: { use: (text: string) => void }) {
    const [files, setFiles] = useState<Earlier[] | null>(null);
    const [error, setError] = useState('');
    useEffect(() => {
        get<{ files: Earlier[] }>(api('history')).then(
            (answer) => setFiles(answer.files), (failed) => setError(errorText(failed)));
    }, []);
    const load = (file: Earlier) => {
        getText(api(`history/${encodeURIComponent(file.id)}`)).then(
            ({ text }) => use(text), (failed) => setError(errorText(failed)));
    };
    return (
        <details>
            <summary>Earlier configurations</summary>
            {error && <p class="error" role="alert">{error}</p>}
            {files?.length === 0 && <p class="quiet">None was kept yet.</p>}
            <ul>
                {files?.map((file) => (
                    <li key={file.id} class="row">
                        <span>{new Date(file.time).toLocaleString()}, {file.bytes} bytes</span>
                        <button onClick={() => load(file)}>Load into the editor</button>
                    </li>
                ))}
            </ul>
        </details>
    );
}
