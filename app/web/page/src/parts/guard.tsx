// If drawing fails, what was drawn before would stay and look live. It is replaced by words.
import { Component, type ComponentChildren } from 'preact';

interface GuardState {
    failed: string;
}

export class Guard extends Component<{ children: ComponentChildren }, GuardState> {
    state: GuardState = { failed: '' };

    componentDidCatch(error: unknown): void {
        this.setState({ failed: String(error) });
    }

    render() {
        if (!this.state.failed) {
            return this.props.children;
        }
        return (
            <main class="alone">
                <h1>This page failed</h1>
                <p role="alert">It shows nothing of the board now. On the board,{' '}
                    <code>tribus monitor</code> shows the same.</p>
                <p>{this.state.failed}</p>
                <button onClick={() => location.reload()}>Load again</button>
            </main>
        );
    }
}
