import { unpaired } from './model/api';
import { sessionError } from './model/session';
import { daemons, screen, type Screen } from './model/store';
import { Frame } from './parts/frame';
import { LiveScreen } from './live/live_screen';
import { PairScreen } from './pair_screen';
import { ConfigScreen } from './config/config_screen';
import { DoctorScreen } from './more/doctor_screen';
import { LearnScreen } from './more/learn_screen';
import { MoreScreen } from './more/more_screen';
import { RecordingsScreen } from './more/recordings_screen';
import { TimingScreen } from './timing/timing_screen';

function Shown({ name }: { name: Screen }) {
    switch (name) {
        case 'live':
            return <LiveScreen />;
        case 'more':
            return <MoreScreen />;
        case 'timing':
            return <TimingScreen />;
        case 'config':
            return <ConfigScreen />;
        case 'doctor':
            return <DoctorScreen />;
        case 'learn':
            return <LearnScreen />;
        case 'recordings':
            return <RecordingsScreen />;
    }
}

/** Before the server has said anything. */
function Waiting() {
    return (
        <main class="alone">
            <h1>tribus</h1>
            <p role="status">{sessionError.value || 'Waiting for the board to say who it is.'}</p>
        </main>
    );
}

function NoDaemon() {
    return (
        <Frame>
            <p>This board has no configuration and runs no daemon. On the board,{' '}
                <code>sudo tribus init</code> asks what is attached and writes the first one.</p>
        </Frame>
    );
}

export function App() {
    if (unpaired.value) {
        return <PairScreen />;
    }
    if (daemons.value === null) {
        return <Waiting />;
    }
    return daemons.value.length === 0 ? <NoDaemon /> : <Frame><Shown name={screen.value} /></Frame>;
}
