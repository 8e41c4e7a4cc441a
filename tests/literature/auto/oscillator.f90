! x'' + (d + g x^2) x' + (a + e cos(omega t)) x + k x^3 = F cos(omega t): the forced
! Duffing, van der Pol and Mathieu equations, made autonomous by an oscillator.
! U = (x, x', p, q), p = cos(omega t), q = -sin(omega t);
! PAR(1:7) = omega, d, g, a, e, k, F; PAR(11) = period. For IPS = 2.

      SUBROUTINE FUNC(NDIM,U,ICP,PAR,IJAC,F,DFDU,DFDP)
      IMPLICIT NONE
      INTEGER, INTENT(IN) :: NDIM, ICP(*), IJAC
      DOUBLE PRECISION, INTENT(IN) :: U(NDIM), PAR(*)
      DOUBLE PRECISION, INTENT(OUT) :: F(NDIM)
      DOUBLE PRECISION, INTENT(INOUT) :: DFDU(NDIM,NDIM), DFDP(NDIM,*)
      DOUBLE PRECISION X,V,P,Q,W,SS
      X = U(1)
      V = U(2)
      P = U(3)
      Q = U(4)
      W = PAR(1)
      SS = P*P + Q*Q
      F(1) = V
      F(2) = PAR(7)*P - (PAR(2) + PAR(3)*X*X)*V - (PAR(4) + PAR(5)*P)*X - PAR(6)*X**3
      F(3) = P + W*Q - P*SS
      F(4) = -W*P + Q - Q*SS
      IF(IJAC==0)RETURN
      DFDU(1:4,1:4) = 0
      DFDU(1,2) = 1
      DFDU(2,1) = -2*PAR(3)*X*V - PAR(4) - PAR(5)*P - 3*PAR(6)*X*X
      DFDU(2,2) = -PAR(2) - PAR(3)*X*X
      DFDU(2,3) = PAR(7) - PAR(5)*X
      DFDU(3,3) = 1 - SS - 2*P*P
      DFDU(3,4) = W - 2*P*Q
      DFDU(4,3) = -W - 2*P*Q
      DFDU(4,4) = 1 - SS - 2*Q*Q
      IF(IJAC==1)RETURN
      DFDP(1:4,1:7) = 0
      DFDP(3,1) = Q
      DFDP(4,1) = -P
      DFDP(2,2) = -V
      DFDP(2,3) = -X*X*V
      DFDP(2,4) = -X
      DFDP(2,5) = -P*X
      DFDP(2,6) = -X**3
      DFDP(2,7) = P
      END SUBROUTINE FUNC

      SUBROUTINE STPNT(NDIM,U,PAR,T)
      IMPLICIT NONE
      INTEGER, INTENT(IN) :: NDIM
      DOUBLE PRECISION, INTENT(INOUT) :: U(NDIM),PAR(*)
      DOUBLE PRECISION, INTENT(IN) :: T
      OPEN(UNIT=31,FILE='start.par',STATUS='OLD')
      READ(31,*) PAR(1:7), PAR(11)
      CLOSE(31)
      END SUBROUTINE STPNT

      SUBROUTINE BCND
      END SUBROUTINE BCND

      SUBROUTINE ICND
      END SUBROUTINE ICND

      SUBROUTINE FOPT
      END SUBROUTINE FOPT

      SUBROUTINE PVLS
      END SUBROUTINE PVLS
