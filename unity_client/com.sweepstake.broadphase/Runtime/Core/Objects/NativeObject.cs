#nullable enable
using System;
using System.Runtime.InteropServices;

namespace Sweepstake
{
    /// <summary>
    /// Owns one object of the native library. Only one caller at a time may use it; distinct objects are independent. Dispose frees it.
    /// <see cref="SweepstakeLibrary.Shutdown"/> frees it too, and each later call then throws.
    /// </summary>
    public abstract class NativeObject : IDisposable
    {
        private readonly NativeHandle handle;
        private readonly int shutdownCount = SweepstakeLibrary.ShutdownCount;

        private protected NativeObject(IntPtr pointer, Action<IntPtr> destroy)
        {
            handle = new NativeHandle(pointer, destroy);
        }

        /// <summary>
        /// The native pointer, for <see cref="LowLevel.NativeMethods"/> in jobs. Keep this object alive while a job uses the pointer.
        /// </summary>
        /// <exception cref="ObjectDisposedException">The object was disposed of.</exception>
        public IntPtr Pointer
        {
            get
            {
                if (handle.IsClosed)
                    throw new ObjectDisposedException(GetType().Name);
                return handle.DangerousGetHandle();
            }
        }

        /// <summary>Whether Dispose or <see cref="SweepstakeLibrary.Shutdown"/> has ended this object.</summary>
        public bool IsDisposed => !HasPointer || shutdownCount != SweepstakeLibrary.ShutdownCount;

        internal bool HasPointer => !handle.IsClosed;

        public virtual void Dispose()
        {
            handle.Dispose();
        }

        /// <summary>
        /// Throws if the call failed. It also keeps this object alive, so that a finalizer does not free it during the call.
        /// </summary>
        private protected void Check(ResultCode result)
        {
            GC.KeepAlive(this);
            if (result != ResultCode.Ok)
                Native.Check(result);
        }

        private sealed class NativeHandle : SafeHandle
        {
            private readonly Action<IntPtr> destroy;

            internal NativeHandle(IntPtr pointer, Action<IntPtr> destroy)
                : base(IntPtr.Zero, true)
            {
                this.destroy = destroy;
                SetHandle(pointer);
            }

            public override bool IsInvalid => handle == IntPtr.Zero;

            protected override bool ReleaseHandle()
            {
                destroy(handle);
                return true;
            }
        }
    }
}
