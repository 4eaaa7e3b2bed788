// The login with a token. The page does not store the token; the daemon sets a cookie that scripts cannot read.
import { useEffect, useRef, useState } from 'preact/hooks';
import { hasLostLogin, login } from '../state/account';
import { asApiError } from '../transport/calls';

export function Login() {
  const [problem, setProblem] = useState('');
  const [isBusy, setBusy] = useState(false);
  const field = useRef<HTMLInputElement>(null);
  useEffect(() => field.current?.focus(), []);
  const submit = async (event: SubmitEvent) => {
    event.preventDefault();
    const form = event.currentTarget as HTMLFormElement;
    const token = String(new FormData(form).get('token')).trim();
    if (!token) return setProblem('Enter a token.');
    setBusy(true);
    try {
      await login(token);
    } catch (error) {
      setProblem(`${asApiError(error).message}.`);
    } finally {
      setBusy(false);
    }
  };
  return (
    <section class="login" aria-labelledby="login-heading">
      <h1 id="login-heading">Log in</h1>
      {hasLostLogin() && <p role="status">Your login has ended: the token has expired or was revoked, or you logged out in another tab. Log in again to continue.</p>}
      <p>You need a token to use this dashboard. The administrator of the daemon creates one:</p>
      <pre>sweepstaked token create NAME --role watch</pre>
      <form onSubmit={(event) => void submit(event)}>
        <label for="token">Token</label>
        <input ref={field} id="token" name="token" type="password" autocomplete="current-password" required spellcheck={false}
          aria-invalid={problem !== ''} aria-describedby="login-problem" />
        <button type="submit" class="primary" disabled={isBusy}>{isBusy ? 'Logging in …' : 'Log in'}</button>
        <p id="login-problem" class="problem" role="alert">{problem}</p>
      </form>
    </section>
  );
}
