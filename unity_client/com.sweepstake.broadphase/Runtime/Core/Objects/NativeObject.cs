#nullable enable
using System;
using System.Runtime.InteropServices;

namespace Sweepstake
{
    /// <summary>
    /// Owns one object of the native library. Only one caller at a time may use it; distinct objects are independent. Dispose frees it.
    /// <see cref="SweepstakeLibrary.Shutdown"/> frees it too, and each later call then throws.
    /// </summary>
    public abstract unsafe class NativeObject : IDisposable
    {
        private readonly NativeHandle handle;
        private readonly int shutdownCount = SweepstakeLibrary.ShutdownCount;

        private protected NativeObject(IntPtr pointer, Action<IntPtr> destroy) => handle = new NativeHandle(pointer, destroy);

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

        public virtual void Dispose() => handle.Dispose();

        /// <summary>Throws if the call failed. It also keeps this object alive, so that a finalizer does not free it during the call.</summary>
        internal void Check(ResultCode result)
        {
            GC.KeepAlive(this);
            if (result != ResultCode.Ok)
                Native.Check(result);
        }

        /// <summary>Calls a native function that writes one value. Allocates nothing with a lambda that captures nothing.</summary>
        /// <param name="value">The value before the call; set StructSize in it if the type has one.</param>
        private protected T Read<T>(ValueReader<T> read, T value = default)
            where T : unmanaged
        {
            Check(read(Pointer, &value));
            return value;
        }

        /// <summary>Calls a native function that returns an array in the library's memory.</summary>
        private protected ReadOnlySpan<T> ReadArray<T>(ArrayReader<T> read)
            where T : unmanaged
        {
            T* start;
            ulong count;
            Check(read(Pointer, &start, &count));
            return new ReadOnlySpan<T>(start, checked((int)count));
        }

        private protected delegate ResultCode ValueReader<T>(IntPtr self, T* value)
            where T : unmanaged;

        private protected delegate ResultCode ArrayReader<T>(IntPtr self, T** start, ulong* count)
            where T : unmanaged;

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
